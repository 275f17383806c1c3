"""Disks that are full, read-only, damaged or pulled out, and photos that are none."""
import os
import random
import re
import shutil
import struct
import subprocess
import zlib

import program
from frame import TEXT, Frame, check

NOTHING_REMEMBERED = "the show goes on, but nothing is remembered"


def image(folder, name, mebibytes, content=None):
    """An ext4 file system in a file of `folder`, with what is in the folder `content`."""
    path = os.path.join(folder, name)
    if os.path.exists(path):
        os.remove(path)
    filled = ["-d", content] if content else []
    subprocess.run(["mke2fs", "-q", "-t", "ext4", *filled, path, "%dM" % mebibytes], check=True, capture_output=True)
    return path


def full(case):
    """A full disk is told once, and written to when there is room."""
    with Frame(case, "bochs") as frame:
        frame.do("mkdir /state; mount -t tmpfs -o size=64k state /state; dd if=/dev/zero of=/state/rubbish bs=4k 2>&1 || true")
        frame.start("kms")
        frame.shows(frame.expected())
        frame.says("No space left.*" + NOTHING_REMEMBERED)
        check("a half-written file stays", frame.do("ls /state") == "rubbish")
        frame.do("rm /state/rubbish")
        frame.end("TERM")
        frame.says("can be written again")
        check("nothing was remembered", frame.do("ls /state") == "state")
        frame.console_is(TEXT)


def read_only(case):
    """The root is mounted read-only: the show runs from memory, which is told once."""
    with Frame(case, "bochs") as frame:
        frame.do("mount -o remount,ro / && ! touch /state")
        frame.start("kms")
        frame.shows(frame.expected())
        frame.end("TERM")
        frame.console_is(TEXT)
        warnings = re.findall("Read-only file system.*" + NOTHING_REMEMBERED, frame.said())
        check("%d warnings" % len(warnings), len(warnings) == 1)


def unreadable(case):
    """A photo stands on bad sectors: it is skipped by name, and the next one shown."""
    folder = os.path.join(program.WORK, case)
    photos = os.path.join(folder, "photos")
    os.makedirs(photos, exist_ok=True)
    for name in ("bad.jpg", "good.jpg"):
        shutil.copyfile(program.PHOTO, os.path.join(photos, name))
    path = image(folder, "photos.ext4", 8, photos)
    blocks = subprocess.run(["debugfs", "-R", "blocks /bad.jpg", path], capture_output=True, text=True, check=True).stdout.split()
    statistics = subprocess.run(["dumpe2fs", "-h", path], capture_output=True, text=True, check=True).stdout
    block_size = int(re.search(r"Block size: +(\d+)", statistics).group(1))
    sector = int(blocks[len(blocks) // 2]) * block_size // 512
    damaged = ("driver=raw,node-name=photos,file.driver=blkdebug,file.image.driver=file,file.image.filename=%s,"
               "file.inject-error.0.event=read_aio,file.inject-error.0.errno=5,file.inject-error.0.once=off,"
               "file.inject-error.0.sector=%d" % (path, sector))
    with Frame(case, "bochs", modules=["virtio_pci", "virtio_blk", "ext4", "crc32c_generic"],
               arguments=["-blockdev", damaged, "-device", "virtio-blk-pci,drive=photos"]) as frame:
        frame.do("mkdir /disk && mount -t ext4 -o ro /dev/vda /disk")
        frame.start("kms", photos="/disk/bad.jpg /disk/good.jpg")
        frame.says("skipped: .*bad.jpg: cannot be read: check the disk")
        frame.shows(frame.expected())


def lost(case):
    """The disk that the show remembers on is pulled out: the show goes on."""
    modules = ["xhci_pci", "usb_storage", "sd_mod", "ext4", "crc32c_generic"]
    with Frame(case, "bochs", modules=modules, arguments=["-device", "qemu-xhci,id=usb"], append="usb_storage.delay_use=0") as frame:
        frame.guest.plug_stick("disk", image(frame.folder, "state.ext4", 16))
        frame.wait("the disk", 10, lambda: frame.guest.shell("[ -b /dev/sda ]")[0] == 0)
        frame.do("mkdir /state && mount -t ext4 /dev/sda /state")
        frame.start("kms", "/photos/demo.jpg /photos/drawn.jpg")
        frame.shows(frame.expected())
        frame.wait("the state is written", 10, lambda: frame.guest.shell("[ -s /state/state ]")[0] == 0)
        frame.guest.unplug_stick("disk")
        frame.guest.press("right")
        frame.shows(frame.expected(program.OTHER_PHOTO, frame=0))
        frame.end("TERM")
        frame.says(NOTHING_REMEMBERED)
        frame.console_is(TEXT)


def corrupt(case):
    """A hundred files that are called photos and are none, or are broken; the last one is good."""
    chance = random.Random(7)
    with open(program.PHOTO, "rb") as f:
        photo = f.read()
    files = {"photos/many/%03d.%s" % (number, "png" if number % 5 == 4 else "jpg"): _corrupt(chance, photo, number % 5)
             for number in range(100)}
    files["photos/many/last.jpg"] = program.OTHER_PHOTO
    with Frame(case, "bochs", files=files) as frame:
        frame.start("kms", photos="/photos/many")
        frame.shows(frame.expected(program.OTHER_PHOTO), timeout=120)
        skipped = set(re.findall(r"skipped: .*?(\d\d\d)\.(?:jpg|png)", frame.said()))
        check("%d of 100 are skipped by name" % len(skipped), len(skipped) == 100)
        frame.end("TERM")
        frame.console_is(TEXT)


def _corrupt(chance, photo, kind):
    """Nothing; a text; noise after a photo's first bytes; a photo cut short within its tables; a PNG of 30,000 × 30,000 pixels."""
    if kind == 0:
        return b""
    if kind == 1:
        return b"This is a text, and no photo.\n"
    if kind == 2:
        return photo[:chance.randrange(4, 300)] + chance.randbytes(2000)
    if kind == 3:
        return photo[:chance.randrange(4, 300)]
    header = b"IHDR" + struct.pack(">IIBBBBB", 30_000, 30_000, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + header + struct.pack(">I", zlib.crc32(header)) + chance.randbytes(100)
