"""Buttons: keyboards that are there, come and go, and those on GPIO pins."""
import time

import program
from frame import TEXT, Frame, check
from machine import PC_WITHOUT_KEYS, VIRT

TWO_PHOTOS = "/photos/demo.jpg /photos/drawn.jpg"
NO_FADE = "[photos]\nfade = 0.0\n"
USB_KEYBOARD = ["xhci_pci", "usbhid", "hid_generic"]


def pressed(case):
    """→ and ← change the photo; ↑ writes the next noise on the picture, for three seconds, and it is remembered."""
    with Frame(case, "bochs", settings=NO_FADE) as frame:
        # A paused show does not bring a photo that comes to life: it stays as it is in frame 0.
        still, other = frame.expected(frame=0), frame.expected(program.OTHER_PHOTO, frame=0)
        frame.start("kms", TWO_PHOTOS)
        frame.shows(frame.expected())
        frame.guest.press("right")
        frame.shows(other)
        frame.guest.press("left")
        frame.shows(still)
        before = _noise(frame)
        frame.guest.press("up")
        frame.differs(still)
        frame.shows(still)
        frame.guest.press("esc")
        frame.has_ended()
        check("the noise is still %s" % before, _noise(frame) != before)
        frame.console_is(TEXT)


def _noise(frame):
    return frame.do("grep amplitude /state/state")


def replugged(case):
    """The only keyboard is plugged in, pulled out with a key down, and plugged in again."""
    with Frame(case, "bochs", machine=PC_WITHOUT_KEYS, modules=USB_KEYBOARD, arguments=["-device", "qemu-xhci,id=usb"],
               settings=NO_FADE) as frame:
        photos = frame.expected(program.OTHER_PHOTO, frame=0), frame.expected(frame=0)
        frame.start("kms", TWO_PHOTOS)
        frame.shows(frame.expected())
        for times, photo in enumerate(photos, 1):
            frame.guest.plug("usb-kbd", "keyboard", bus="usb.0")
            frame.says(r"buttons: .*USB Keyboard at \S+$", times=times)
            # QEMU may lose the first keys after a plug: some that do nothing go before.
            for _ in range(5):
                frame.guest.press("shift")
                time.sleep(0.3)
            frame.guest.press("right")
            frame.shows(photo)
            frame.guest.qmp("input-send-event", events=[_down("right")])
            frame.guest.unplug("keyboard")
            frame.says("buttons: .*is gone", times=times)
            frame.guest.press("left")
            frame.shows(photo)


def _down(key):
    return {"type": "key", "data": {"down": True, "key": {"type": "qcode", "data": key}}}


def on_pins(case):
    """QEMU's power button is a key of gpio-keys there."""
    with Frame(case, "virtio", size=(1024, 600), machine=VIRT, modules=["gpio_pl061", "gpio_keys"],
               settings=NO_FADE + '[keys]\nKEY_POWER = "right"\n') as frame:
        frame.start("kms", TWO_PHOTOS)
        frame.shows(frame.expected())
        frame.guest.qmp("system_powerdown")
        frame.shows(frame.expected(program.OTHER_PHOTO, frame=0))
