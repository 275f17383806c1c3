#!/bin/busybox sh
# The guest's /init: loads /etc/modules in order, with the parameters that the kernel's command line has as module.name=value, says
# VM-READY on the console, and then runs the shell commands that come on the serial line that vm.shell= names.
export PATH=/bin:/sbin HOME=/root
/bin/busybox --install -s /bin
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t devtmpfs dev /dev 2>/dev/null
mount -t tmpfs tmp /tmp
exec </dev/console >/dev/console 2>&1
while read -r module; do
    options=
    for word in $(cat /proc/cmdline); do
        case $word in $module.*) options="$options ${word#*.}" ;; esac
    done
    insmod "/lib/modules/$module.ko" $options || echo "VM-ERROR insmod $module $options"
done </etc/modules
echo VM-READY
line=$(sed 's/.*vm.shell=\([^ ]*\).*/\1/' /proc/cmdline)
exec 3<>"$line"
stty raw -echo 115200 <&3
# A serial line loses what was sent before it was opened: the host waits for this.
echo __OPEN >&3
# Lines "NUMBER COMMAND"; after the command's output comes __END, the number and the status.
while IFS= read -r line; do
    (eval "${line#* }") </dev/null 3<&-
    status=$?
    echo
    echo "__END${line%% *}_${status}_"
done <&3 >&3 2>&1
