"""A photo frame: a guest with a display in which the program runs."""
import os
import re
import time

import initramfs
import program
from display import Display
from guest import Guest
from machine import PC, PI_3
from picture import Picture

# A show that is paused shows this frame, and nothing else, until it is told otherwise.
STILL_FRAME = 12
TEXT, PICTURE = "tty1 is seen: text, switched by the kernel", "tty1 is seen: graphics, switched after asking a program"


class Failed(Exception):
    """What is not as it should be."""


def check(what, is_so):
    if not is_so:
        raise Failed(what)


class Frame:
    """Whatever fails leaves its pictures and words in target/vm/CASE. `files` are more for the guest, as those of
    initramfs.build; `settings` is the text of a configuration."""

    def __init__(self, case, card, size=(800, 600), pixel_format="XRGB8888", machine=PC, modules=(), arguments=(), append="",
                 files=(), settings=None, life=200):
        self.size, self.pixel_format, self.machine, self.settings = size, pixel_format, machine, settings
        self.folder = os.path.join(program.WORK, case)
        os.makedirs(self.folder, exist_ok=True)
        self.display = Display(card, size)
        files = {"bin/yurameki": machine.binary, "photos/demo.jpg": program.PHOTO, "photos/drawn.jpg": program.OTHER_PHOTO,
                 "etc/frame.toml": (settings or "").encode(), **dict(files)}
        archive = os.path.join(self.folder, "initramfs.cpio")
        initramfs.build(machine.kernel, archive, self.display.modules + machine.modules + ["evdev", *modules], files)
        log = os.path.join(self.folder, "console.log")
        self.guest = Guest(machine, self.display, archive, log, arguments, append, life=life)

    def __enter__(self):
        self.guest.__enter__()
        if self.display.memory_depth:
            self.do(self.display.set_size())
        return self

    def __exit__(self, *_):
        try:
            with open(os.path.join(self.folder, "program.log"), "w") as f:
                f.write(self.said())
        except (OSError, RuntimeError):
            pass    # the guest is gone, and says so itself
        self.guest.__exit__()

    def do(self, command):
        """Runs a command that must succeed: its output."""
        status, output = self.guest.shell(command)
        check("%s: status %d, %s" % (command, status, output), status == 0)
        return output

    def start(self, display, photos="/photos/demo.jpg", environment="", pausing=True):
        """Starts the program, which pauses by itself at the frame that is looked for. It remembers in /state."""
        self.do("echo %s >/tmp/script" % ("%d SPACE" % STILL_FRAME if pausing else ""))
        settings = "--config /etc/frame.toml" if self.settings else ""
        self.do("STATE_DIRECTORY=/state RUST_LOG=debug %s yurameki run %s --display %s %s --mask none --script /tmp/script "
                ">/tmp/out 2>&1 &" % (environment, photos, display, settings))
        self.says("showing on|waiting for it")

    def run(self, display):
        """Two frames of a second program: (its status, its words)."""
        return self.guest.shell("yurameki run /photos/demo.jpg --display %s --frames 2 2>&1" % display)

    def end(self, signal):
        self.do("kill -%s $(pidof yurameki)" % signal)
        self.has_ended()

    def has_ended(self):
        self.wait("the program's end", 30, lambda: not self.is_alive())

    def is_alive(self):
        return self.guest.shell("pidof yurameki")[0] == 0

    def said(self):
        return self.guest.shell("cat /tmp/out 2>/dev/null")[1]

    def says(self, pattern, timeout=30, times=1):
        self.wait("the program says %r" % pattern, timeout, lambda: len(re.findall(pattern, self.said(), re.M)) >= times)

    def expected(self, photo=program.PHOTO, size=None, frame=STILL_FRAME):
        picture = program.rendered(photo, size or self.size, self.pixel_format, frame)
        return picture.as_simple_frame_buffer() if self.machine is PI_3 else picture

    def seen(self, head=0):
        if not self.display.memory_depth:
            return self.guest.screen(head)
        stride, pan = self.do("cd /sys/class/graphics/fb0; cat stride pan").split()
        memory = self.guest.blocks("/dev/fb0", int(stride), int(pan.split(",")[1]), self.size[1])
        return Picture.from_memory(self.size, int(stride), self.pixel_format, memory)

    def shows(self, picture, timeout=60, head=0):
        """Drivers bring a drawn page to the screen up to 50 ms later, and emulation is slow: look until it is there, and stays
        there for more than a frame (83 ms). A screen is read in 10 ms, memory in a second."""
        seen, times = None, 0

        def look():
            nonlocal seen, times
            seen = self.seen(head)
            times = times + 1 if seen == picture else 0
            return times == (2 if self.display.memory_depth else 8)
        try:
            self.wait("the picture", timeout, look)
        except Failed:
            picture.save_png(os.path.join(self.folder, "expected.png"))
            seen.save_png(os.path.join(self.folder, "seen.png"))
            raise Failed("the screen: " + seen.difference(picture)) from None

    def differs(self, picture):
        self.wait("another picture", 30, lambda: self.seen() != picture)

    def is_black(self):
        self.wait("a black panel", 30, lambda: self.seen().is_black())

    def console_is(self, state):
        """`yurameki probe` says who draws on the console that is seen."""
        self.wait("the console %r" % state, 30, lambda: state in self.guest.shell("yurameki probe 2>/dev/null")[1])

    def text_is_seen(self, tty):
        self.do("for i in $(seq 40); do echo line $i of text >/dev/%s; done" % tty)
        self.wait("text on " + tty, 30, lambda: 0.001 < self.seen().bright_share() < 0.4)

    def connect(self, connector, status):
        self.do("echo %s >/sys/class/drm/card0-%s/status" % (status, connector))

    @staticmethod
    def wait(what, timeout, is_so):
        deadline = time.monotonic() + timeout
        while not is_so():
            if time.monotonic() > deadline:
                raise Failed("not in %d s: %s" % (timeout, what))
            time.sleep(0.05)
