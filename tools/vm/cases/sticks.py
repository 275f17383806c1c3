"""Photos on a USB stick. Here the guest mounts sticks with the options of board/usb by a loop of its shell; the udev rule and the
service that do so on a board need systemd, which the guest has not, and are not tried."""
import os
import subprocess

import program
from frame import Frame, check

MODULES = ["xhci_pci", "usb_storage", "sd_mod", "vfat", "nls_cp437", "nls_ascii", "nls_utf8"]
ARGUMENTS = ["-device", "qemu-xhci,id=usb"]
SETTINGS = '[photos]\nfolders = ["/media/yurameki"]\nfade = 0.0\n'
# The number of a FAT file system is its UUID.
MOUNTING = b"""place=
while sleep 0.2; do
    if [ -b /dev/sda ] && [ -z "$place" ]; then
        place=/media/yurameki/$(dd if=/dev/sda bs=1 skip=39 count=4 2>/dev/null | od -An -tx1 | tr -d ' ')
        mkdir -p $place
        mount -t vfat -o ro,nosuid,nodev,noexec,noatime,utf8 /dev/sda $place
    elif [ ! -b /dev/sda ] && [ -n "$place" ]; then
        umount -l $place
        rmdir $place
        place=
    fi
done
"""


def _stick(frame, photo):
    image = os.path.join(frame.folder, os.path.basename(photo) + ".vfat")
    with open(image, "wb") as f:
        f.truncate(16 << 20)
    for command in (["mkfs.vfat", image], ["mmd", "-i", image, "::/DCIM"], ["mcopy", "-i", image, photo, "::/DCIM/Fünf 写真.jpg"]):
        subprocess.run(command, check=True, capture_output=True, env={**os.environ, "LC_ALL": "C.UTF-8"})
    return image


def played(case):
    """A stick plays once it is plugged in; pulled out, the last picture stays; the next stick plays."""
    with Frame(case, "bochs", modules=MODULES, arguments=ARGUMENTS, append="usb_storage.delay_use=0",
               files={"bin/mounting": MOUNTING}, settings=SETTINGS) as frame:
        frame.do("mkdir -p /media/yurameki; sh /bin/mounting >/dev/null 2>&1 &")
        frame.start("kms", photos="")
        frame.guest.plug_stick("first", _stick(frame, program.OTHER_PHOTO), removable=True)
        frame.shows(frame.expected(program.OTHER_PHOTO))
        frame.guest.unplug_stick("first")
        frame.wait("the stick is unmounted", 10, lambda: not frame.do("ls /media/yurameki"))
        frame.shows(frame.expected(program.OTHER_PHOTO))
        frame.guest.plug_stick("second", _stick(frame, program.PHOTO), removable=True)
        frame.shows(frame.expected(frame=0))
        check("the program has ended", frame.is_alive())
