"""The panel: every pixel of the paused frame, and what becomes of the show when panels come and go."""
from frame import PICTURE, TEXT, Frame, check


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
            frame.says("gone", times=times)
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
