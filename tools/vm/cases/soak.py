"""A long time: its memory must not grow."""
import os
import re

import program
from frame import Frame, check

# What is shown in turn, each for five seconds: small ones, of every kind, because what a minute costs is their decoding.
PHOTOS = ["drawn.jpg", "drawn.png", "drawn.bmp", "drawn.tif", "animated.gif", "animated.webp", "alpha.png", "sixteen.png",
          "progressive.jpg", "lossy.webp"]
SETTINGS = '[photos]\nfolders = ["/photos/small"]\nseconds = 5\nfade = 1.0\n'
# How far the memory may go up and down, in KiB; a leak of 100 bytes a frame is 8 MB in two hours.
SWING = 400


def memory_stays(case, minutes):
    """The guest's clock follows its instructions (8 ns each) and leaps while it waits: an hour of its time is some minutes of ours.
    Photos come and go on the way, and keys are pressed. target/vm/soak/memory has what was seen."""
    files = {"photos/small/" + name: os.path.join(program.ROOT, "tests", "data", name) for name in PHOTOS}
    with Frame(case, "vfb32", size=(160, 120), files=files, arguments=["-icount", "shift=3,sleep=off"], settings=SETTINGS,
               life=3600 + minutes * 60) as frame:
        frame.start("fbdev", photos="", pausing=False)
        start, samples, keys = _uptime(frame), [], 0
        while (now := _uptime(frame)) < start + minutes * 60:
            samples.append((now, int(frame.do("sed -n 's/^RssAnon:[^0-9]*\\([0-9]*\\).*/\\1/p' /proc/$(pidof yurameki)/status"))))
            frame.guest.press(("right", "up", "down", "left")[keys % 4])
            keys += 1
            frame.do("cp /photos/drawn.jpg /photos/small/new.jpg; sleep 5; rm /photos/small/new.jpg; sleep 10")
        with open(os.path.join(frame.folder, "memory"), "w") as f:
            f.writelines("%d s  %d KiB\n" % (when - start, kibibytes) for when, kibibytes in samples)
        # The new one may be gone before its turn.
        check("a photo was skipped: " + frame.said(), not re.search("skipped: (?!/photos/small/new.jpg)", frame.said()))
        _check_flat(samples, start, minutes)
        frame.end("TERM")


def _uptime(frame):
    return float(frame.do("cut -d' ' -f1 /proc/uptime"))


def _check_flat(samples, start, minutes):
    """The first quarter is for what is filled once."""
    settled = [kibibytes for when, kibibytes in samples if when > start + minutes * 15]
    half = len(settled) // 2
    check("too few samples: %d" % len(settled), half >= 3)
    early, late = max(settled[:half]), max(settled[half:])
    check("the memory has grown from %d to %d KiB: %s" % (early, late, settled), late <= early + SWING)
