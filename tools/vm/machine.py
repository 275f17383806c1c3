"""What QEMU emulates: a PC, ARM's virtual board, a Raspberry Pi 3. Plain emulation (TCG) only: three seconds to boot, and the same
everywhere. /dev/kvm may be there and yet be unable to run a stock kernel, as within some virtual machines."""
import functools
import glob
import os
import subprocess

import device_tree
import program

FETCH = os.path.join(os.path.dirname(os.path.abspath(__file__)), "fetch-kernel")


class Machine:
    def __init__(self, architecture, arguments, append, shell, shell_line, modules=()):
        self.architecture, self.modules = architecture, list(modules)
        self.qemu = {"amd64": "qemu-system-x86_64", "arm64": "qemu-system-aarch64"}[architecture]
        self.arguments = [self.qemu, "-accel", "tcg", *arguments]
        # How QEMU gives the guest's shell a serial line, and the guest's name for it.
        self.shell = shell
        self.append = "%s vm.shell=%s" % (append, shell_line)

    @property
    def kernel(self):
        """The folder of its kernel."""
        return fetch_kernel(self.architecture)

    @property
    def binary(self):
        return program.build(self.architecture)

    def boot_arguments(self, display, folder):
        """The kernel's file, and what else the machine needs for this display; `folder` is for files that are made."""
        unpacked = os.path.join(self.kernel, "vmlinux")
        is_unpacked = os.path.exists(unpacked) and not display.by_firmware
        arguments = ["-kernel", unpacked if is_unpacked else os.path.join(self.kernel, "vmlinuz")]
        if self is PI_3:
            pattern = os.path.join(self.kernel, "root/usr/lib/linux-image*/broadcom/bcm2837-rpi-3-b.dtb")
            with open(glob.glob(pattern)[0], "rb") as f:
                tree = device_tree.with_frame_buffer(f.read(), display.size)
            with open(os.path.join(folder, "dtb"), "wb") as f:
                f.write(tree)
            arguments += ["-dtb", f.name]
        return arguments


@functools.lru_cache(maxsize=None)
def fetch_kernel(architecture):
    folder = os.path.join(program.WORK, "kernel-" + architecture)
    if subprocess.run([FETCH, folder, architecture]).returncode:
        raise program.Missing("Debian's kernel cannot be fetched; `apt-get download linux-image-%s` must work" % architecture)
    return folder


# The emulated time stamp counter is the host's, whose rate a loaded guest measures wrong; without it the guest goes by QEMU's own
# clock.
PC = Machine("amd64", ["-M", "q35", "-cpu", "qemu64,-tsc", "-m", "384"], "console=ttyS0 no_timer_check mitigations=off",
             ["-serial", "chardev:shell"], "/dev/ttyS1")
# The same without the keyboard that every PC has.
PC_WITHOUT_KEYS = Machine("amd64", ["-M", "q35,i8042=off", *PC.arguments[5:]], "console=ttyS0 no_timer_check mitigations=off",
                          PC.shell, "/dev/ttyS1")
VIRT = Machine("arm64", ["-M", "virt", "-cpu", "cortex-a53", "-m", "384", "-device", "virtio-keyboard-pci"], "console=ttyAMA0",
               ["-device", "pci-serial,chardev=shell"], "/dev/ttyS0", ["virtio_pci", "virtio_input"])
# Of its four processors one is used: each costs the emulator as much.
PI_3 = Machine("arm64", ["-M", "raspi3b", "-device", "usb-kbd"], "console=ttyAMA0,115200 maxcpus=1",
               ["-serial", "chardev:shell"], "/dev/ttyS1", ["phy_generic", "dwc2", "usbhid", "hid_generic"])
