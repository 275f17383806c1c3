"""The power is cut while the frame writes what it remembers."""
import hashlib
import os
import random
import re
import shutil
import subprocess
import time

import program
from frame import Frame, check
from guest import Guest

from .disk import image

FIRST, LAST = 1000, 1399
# Every run of this shows three tiny frames and hides a photo for ever, and so writes both files.
WRITING = b"""mkdir /many
for number in $(seq %d %d); do ln /photos/drawn.jpg /many/$number.jpg; done
printf '1 RIGHT\\n2 ENTER long\\n' >/tmp/script
while yurameki run /many --display sim:32x24 --frames 3 --mask none --script /tmp/script; do :; done
""" % (FIRST, LAST)
MODULES = ["virtio_pci", "virtio_blk", "ext4", "crc32c_generic"]


# How the disk is mounted: ext4 by itself makes good much of what a program leaves out. Here every step goes to the disk by itself,
# so that a file that is emptied and then written is seen empty; and names go there before contents that nobody has synchronised.
MOUNTS = ["sync", "noauto_da_alloc,commit=1"]


def cut(case, cuts):
    """The machine goes on from one and the same moment again and again, and is killed up to 1.5 seconds later. Each time the disk
    has the old state or the new one, and no broken one, and the program goes on from the last."""
    folder = os.path.join(program.WORK, case)
    os.makedirs(folder, exist_ok=True)
    for options in MOUNTS:
        disk = image(folder, "state.ext4", 16)
        # The disk does 40 things a second, so that for most of the time a write is going on.
        arguments = ["-drive", "if=none,id=state,format=raw,throttling.iops-total=40,file=" + disk,
                     "-device", "virtio-blk-pci,drive=state"]
        before, found = _cut(case, disk, arguments, options, -(-cuts // len(MOUNTS)))
        check("nothing was written in any of the cuts", max(found) > before)
        check("what was written is lost", min(found) >= before)
    with Frame(case, "bochs", modules=MODULES, arguments=arguments) as frame:
        frame.do("mkdir /state && mount -t ext4 /dev/vda /state")
        frame.start("kms")
        frame.shows(frame.expected())
        check("the state is not taken up: " + frame.said(), "starting afresh" not in frame.said())


def _cut(case, disk, arguments, options, cuts):
    """How many photos were hidden before, and after each of the cuts."""
    saved, start = disk + ".machine", disk + ".start"
    with Frame(case, "bochs", modules=MODULES, arguments=arguments, files={"bin/writing": WRITING}) as frame:
        guest = frame.guest
        frame.do("mkdir /state && mount -t ext4 -o %s /dev/vda /state" % options)
        frame.do("STATE_DIRECTORY=/state sh /bin/writing >/tmp/out 2>&1 &")
        frame.wait("five photos are hidden", 60, lambda: guest.shell("[ $(grep -c . /state/hidden.txt) -ge 5 ]")[0] == 0)
        guest.save_as(saved)
    shutil.copyfile(disk, start)
    before, found = _hidden(disk), []
    for _ in range(cuts):
        shutil.copyfile(start, disk)
        with Guest(guest.machine, guest.display, guest.initramfs, guest.log, arguments, saved_as=saved) as again:
            again.go_on()
            time.sleep(random.uniform(0, 1.5))
            again.cut_power()
        found.append(_hidden(disk))
    return before, found


def _hidden(disk):
    """How many photos are hidden on a disk that is as a cut has left it, once all that is there has been found whole. The file
    system's check does what a mount would: it takes its journal up."""
    check("the file system is broken", subprocess.run(["e2fsck", "-fy", disk], capture_output=True).returncode < 4)
    names = _read(disk, "ls -p /").decode()
    check("there is a damaged state", "state.bad" not in names)
    title, _, body = _read(disk, "cat /state").partition(b"\n")
    check("the state is broken: %r" % title, title == b"yurameki state 1 " + hashlib.sha256(body).hexdigest().encode())
    hidden = _read(disk, "cat /hidden.txt").decode()
    check("the list of the hidden is broken: %r" % hidden, re.fullmatch(r"(/many/\d{4}\.jpg\n)+", hidden))
    return hidden.count("\n")


def _read(disk, request):
    return subprocess.run(["debugfs", "-R", request, disk], capture_output=True, check=True).stdout
