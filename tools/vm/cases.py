"""The cases: the program on a panel of a real kernel, watched from outside."""
import os
import re
import time

import initramfs
import program
from guest import Display, Guest

KERNEL = os.path.join(program.WORK, "kernel")
# A show that is paused shows this frame, and nothing else, until it is told otherwise.
STILL_FRAME = 12
TEXT, PICTURE = "tty1 is seen: text, switched by the kernel", "tty1 is seen: graphics, switched after asking a program"


class Failed(Exception):
    """What is not as it should be."""


class Frame:
    """A guest with a display, in which the program runs. Whatever fails leaves its pictures and words in target/vm/CASE."""

    def __init__(self, case, display, size=(800, 600), pixel_format="XRGB8888"):
        self.size, self.pixel_format = size, pixel_format
        self.folder = os.path.join(program.WORK, case)
        os.makedirs(self.folder, exist_ok=True)
        self.display = Display(display, size)
        files = {"bin/yurameki": program.BINARY, "photos/demo.jpg": program.PHOTO, "photos/drawn.jpg": program.OTHER_PHOTO}
        archive = os.path.join(self.folder, "initramfs.cpio")
        initramfs.build(KERNEL, archive, self.display.modules + ["evdev"], files)
        self.guest = Guest(KERNEL, archive, self.display, os.path.join(self.folder, "console.log"))

    def __enter__(self):
        self.guest.__enter__()
        return self

    def __exit__(self, *_):
        try:
            with open(os.path.join(self.folder, "program.log"), "w") as f:
                f.write(self.said())
        except (OSError, RuntimeError):
            pass    # the guest is gone, and says so itself
        self.guest.__exit__()

    def start(self, display, photos="/photos/demo.jpg"):
        """Starts the program, which pauses by itself at the frame that is looked for."""
        self.guest.shell("echo %d SPACE >/tmp/script" % STILL_FRAME)
        self.guest.shell("RUST_LOG=debug yurameki run %s --display %s --mask none --script /tmp/script >/tmp/out 2>&1 &"
                         % (photos, display))
        self.says("showing on|waiting for it", 30)

    def run(self, display):
        """Two frames of a second program: (its status, its words)."""
        return self.guest.shell("yurameki run /photos/demo.jpg --display %s --frames 2 2>&1" % display)

    def end(self, signal):
        self.guest.shell("kill -%s $(pidof yurameki)" % signal)
        self.has_ended()

    def has_ended(self):
        self._wait("the program's end", 15, lambda: self.guest.shell("pidof yurameki")[0])

    def said(self):
        return self.guest.shell("cat /tmp/out 2>/dev/null")[1]

    def says(self, pattern, timeout=20):
        self._wait("the program says %r" % pattern, timeout, lambda: re.search(pattern, self.said()))

    def expected(self, photo=program.PHOTO, size=None, frame=STILL_FRAME):
        return program.rendered(photo, size or self.size, self.pixel_format, frame)

    def shows(self, picture, timeout=25, head=0):
        """Drivers bring a drawn page to the screen up to 50 ms later, and emulation is slow: look until it is there, and stays
        there for more than a frame (83 ms)."""
        seen, times = None, 0

        def look():
            nonlocal seen, times
            seen = self.guest.screen(head)
            times = times + 1 if seen == picture else 0
            return times == 8
        try:
            self._wait("the picture", timeout, look)
        except Failed:
            picture.save_png(os.path.join(self.folder, "expected.png"))
            seen.save_png(os.path.join(self.folder, "seen.png"))
            raise Failed("the screen: " + seen.difference(picture)) from None

    def differs(self, picture, timeout=10):
        self._wait("another picture", timeout, lambda: self.guest.screen() != picture)

    def console_is(self, state):
        """`yurameki probe` ends with who draws on the console that is seen."""
        self._wait("the console %r" % state, 10, lambda: state in self.guest.shell("yurameki probe 2>/dev/null | tail -1")[1])

    def text_is_seen(self, tty):
        self.guest.shell("for i in $(seq 40); do echo line $i of text >/dev/%s; done" % tty)
        self._wait("text on " + tty, 10, lambda: 0.001 < self.guest.screen().bright_share() < 0.4)

    def connect(self, connector, status):
        self.guest.shell("echo %s >/sys/class/drm/card0-%s/status" % (status, connector))

    @staticmethod
    def _wait(what, timeout, is_so):
        deadline = time.monotonic() + timeout
        while not is_so():
            if time.monotonic() > deadline:
                raise Failed("not in %d s: %s" % (timeout, what))
            time.sleep(0.05)


def check(what, is_so):
    if not is_so:
        raise Failed(what)


def shown(case, card, display, **panel):
    """The paused frame is on the panel, pixel by pixel, and SIGTERM gives the console back."""
    with Frame(case, card, **panel) as frame:
        frame.start(display)
        frame.shows(frame.expected())
        frame.console_is(PICTURE)
        frame.end("TERM")
        frame.console_is(TEXT)


def panned(case):
    """The same where the driver pans: two pages, shown in turn."""
    with Frame(case, "cirrusfb", pixel_format="RGB565") as frame:
        frame.start("fbdev")
        frame.says("two pages panned")
        frame.shows(frame.expected())
        frame.end("TERM")


def console(case, card, display):
    """Consoles are switched there and back; text is seen after SIGHUP, SIGTERM, and SIGKILL with `restore-console`."""
    with Frame(case, card) as frame:
        frame.console_is(TEXT)
        frame.start(display)
        frame.shows(frame.expected())
        for _ in range(3):
            frame.guest.shell("chvt 2")
            frame.console_is("tty2 is seen: text")
            frame.text_is_seen("tty2")
            frame.guest.shell("chvt 1")
            frame.shows(frame.expected())
        for signal in ("HUP", "TERM"):      # not INT, which sh has its background jobs ignore
            frame.end(signal)
            frame.console_is(TEXT)
            frame.text_is_seen("tty1")
            frame.start(display)
            frame.shows(frame.expected())
        frame.end("KILL")
        frame.console_is("graphics")
        status, words = frame.guest.shell("yurameki restore-console 2>&1")
        check("restore-console: %s" % words, status == 0)
        frame.console_is(TEXT)
        frame.text_is_seen("tty1")


def buttons(case):
    """→ and ← change the photo; ↑ writes the next noise on the picture, for three seconds."""
    with Frame(case, "bochs") as frame:
        # A paused show does not bring a photo that comes to life: it stays as it is in frame 0.
        still, other = frame.expected(frame=0), frame.expected(program.OTHER_PHOTO, frame=0)
        frame.start("kms", "/photos/demo.jpg /photos/drawn.jpg")
        frame.shows(frame.expected())
        frame.guest.press("right")
        frame.shows(other)
        frame.guest.press("left")
        frame.shows(still)
        frame.guest.press("up")
        frame.differs(still)
        frame.shows(still)
        frame.guest.press("esc")
        frame.has_ended()
        frame.console_is(TEXT)


def unplugged(case):
    """Nothing is connected at first; then the panel is plugged in, unplugged and plugged in again, twice."""
    with Frame(case, "virtio", size=(1024, 768)) as frame:
        frame.connect("Virtual-1", "off")
        frame.start("kms")
        frame.says("waiting for it")
        frame.connect("Virtual-1", "on")
        frame.shows(frame.expected())
        for times in (1, 2):
            frame.connect("Virtual-1", "off")
            frame.says("(?s)(gone.*){%d}" % times)
            frame.connect("Virtual-1", "on")
            frame.shows(frame.expected())


def moved(case):
    """The panel goes away, the show goes on on the other one, in its mode, and comes back."""
    with Frame(case, "virtio-padded") as frame:
        frame.start("kms")
        frame.shows(frame.expected())
        frame.connect("Virtual-1", "off")
        frame.says("1024×600")
        frame.shows(frame.expected(size=(1024, 600), frame=0), head=1)
        frame.connect("Virtual-1", "on")
        frame.connect("Virtual-2", "off")
        frame.shows(frame.expected(frame=0))


def held(case):
    """A mode is chosen; a second program is told who holds the card; a mode that is not there gives the preferred one."""
    with Frame(case, "bochs") as frame:
        frame.start("kms:0:Virtual-1:640x480")
        frame.shows(frame.expected(size=(640, 480)))
        for display in ("kms", "auto"):
            status, words = frame.run(display)
            check("not refused by name: " + words, status == 1 and "held by yurameki (" in words)
        frame.end("TERM")
        status, words = frame.run("kms:::123x456")
        check("no word of the mode: " + words, status == 0 and "no mode 123" in words)


ODD = (1366, 768)
CORE = ["bochs-kms", "bochs-fbdev", "vesa16", "virtio-padded", "console-kms", "buttons"]
# Name: (what it shows, the case).
CASES = {
    "bochs-kms": ("KMS, XRGB8888, page flips", lambda case: shown(case, "bochs", "kms")),
    "bochs-fbdev": ("frame buffer, XRGB8888", lambda case: shown(case, "bochs", "fbdev")),
    "vesa16": ("frame buffer, RGB565", lambda case: shown(case, "vesa16", "fbdev", pixel_format="RGB565")),
    "virtio-padded": ("frame buffer, lines longer than shown", lambda case: shown(case, "virtio-padded", "fbdev")),
    "console-kms": ("consoles switched; text after each end", lambda case: console(case, "bochs", "kms")),
    "buttons": ("keys change the photo and the noise", buttons),
    "bochs-auto": ("the display found by itself", lambda case: shown(case, "bochs", "auto")),
    "virtio-odd-kms": ("KMS, 1366×768", lambda case: shown(case, "virtio", "kms", size=ODD)),
    "virtio-odd-fbdev": ("frame buffer, 1366×768", lambda case: shown(case, "virtio", "fbdev", size=ODD)),
    "vesa24": ("frame buffer, packed 24 bits", lambda case: shown(case, "vesa24", "fbdev", pixel_format="RGB888")),
    "cirrus-fbdev": ("frame buffer of DRM, RGB565", lambda case: shown(case, "cirrus", "fbdev", pixel_format="RGB565")),
    "cirrusfb-pan": ("frame buffer, two pages panned", panned),
    "console-fbdev": ("as console-kms, frame buffer", lambda case: console(case, "bochs", "fbdev")),
    "console-virtio": ("as console-kms, virtio", lambda case: console(case, "virtio", "kms")),
    "unplugged": ("the panel unplugged and back", unplugged),
    "moved": ("the show moves to another panel and back", moved),
    "held": ("the card is held; a mode is chosen", held),
}
