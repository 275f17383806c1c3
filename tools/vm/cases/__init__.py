"""The cases: the program on a panel of a real kernel, watched from outside."""
from machine import PI_3, VIRT

from . import buttons, clock, console, disk, panels, power, soak, sticks

ODD, SMALL = (1366, 768), (333, 201)
CORE = ["bochs-kms", "bochs-fbdev", "vesa16", "virtio-padded", "console-kms", "buttons"]
# By hand for longer.
CUTS, MINUTES = 50, 5


def table(cuts=CUTS, minutes=MINUTES):
    """{name: (what it shows, the case)}."""
    shown = panels.shown
    return {
        "bochs-kms": ("KMS, XRGB8888, page flips", lambda case: shown(case, "bochs", "kms")),
        "bochs-fbdev": ("frame buffer, XRGB8888", lambda case: shown(case, "bochs", "fbdev")),
        "vesa16": ("frame buffer, RGB565", lambda case: shown(case, "vesa16", "fbdev", pixel_format="RGB565")),
        "virtio-padded": ("frame buffer, lines longer than shown", lambda case: shown(case, "virtio-padded", "fbdev")),
        "console-kms": ("consoles switched; text after each end, kill -9 too", lambda case: console.switched(case, "bochs", "kms")),
        "buttons": ("keys change the photo and the noise", buttons.pressed),
        "bochs-auto": ("the display found by itself", lambda case: shown(case, "bochs", "auto")),
        "virtio-odd-kms": ("KMS, 1366×768", lambda case: shown(case, "virtio", "kms", size=ODD)),
        "virtio-odd-fbdev": ("frame buffer, 1366×768", lambda case: shown(case, "virtio", "fbdev", size=ODD)),
        "vesa24": ("frame buffer, packed 24 bits", lambda case: shown(case, "vesa24", "fbdev", pixel_format="RGB888")),
        "cirrus-fbdev": ("frame buffer of DRM, RGB565", lambda case: shown(case, "cirrus", "fbdev", pixel_format="RGB565")),
        "cirrusfb-pan": ("frame buffer, two pages panned", panels.panned),
        "vfb16": ("BGR565, 333×201, padded lines", lambda case: shown(case, "vfb16", "fbdev", size=SMALL, pixel_format="BGR565")),
        "vfb24": ("BGR888, 333×201, padded lines", lambda case: shown(case, "vfb24", "fbdev", size=SMALL, pixel_format="BGR888")),
        "vfb32": ("XBGR8888, 333×201", lambda case: shown(case, "vfb32", "fbdev", size=SMALL, pixel_format="XBGR8888")),
        "virt-kms": ("ARM, KMS on virtio", lambda case: shown(case, "virtio", "kms", size=(1024, 600), machine=VIRT)),
        "virt-pins": ("ARM, a button on a GPIO pin", buttons.on_pins),
        "pi-3": ("a Raspberry Pi 3, simple frame buffer, RGB565",
                 lambda case: shown(case, "simple", "fbdev", pixel_format="RGB565", machine=PI_3)),
        "console-fbdev": ("as console-kms, frame buffer", lambda case: console.switched(case, "bochs", "fbdev")),
        "console-virtio": ("as console-kms, virtio", lambda case: console.switched(case, "virtio", "kms")),
        "panic": ("text after a panic", console.panicked),
        "unplugged": ("the panel unplugged and back", panels.unplugged),
        "moved": ("the show moves to another panel and back", panels.moved),
        "held": ("the card is held; a mode is chosen", panels.held),
        "keyboard": ("the keyboard unplugged and back", buttons.replugged),
        "stick": ("a USB stick plays; pulled out; another plays", sticks.played),
        "corrupt": ("100 files that are no photos", disk.corrupt),
        "unreadable": ("a photo on bad sectors", disk.unreadable),
        "disk-full": ("nothing can be remembered on a full disk", disk.full),
        "disk-lost": ("the disk with the state is pulled out", disk.lost),
        "read-only": ("a read-only root", disk.read_only),
        "clock": ("the clock is wrong at boot", clock.wrong),
        "power-cut": ("the power cut %d times during writes" % cuts, lambda case: power.cut(case, cuts)),
        "soak": ("%d minutes of the guest's time: memory stays" % minutes, lambda case: soak.memory_stays(case, minutes)),
    }


# Those that need the kernel and the program for ARM.
ON_ARM = {"virt-kms", "virt-pins", "pi-3"}
