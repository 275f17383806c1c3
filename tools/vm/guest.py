"""A virtual machine: a Debian kernel under QEMU, its shell by a serial line, its keys and its screen by QMP."""
import base64
import ctypes
import os
import re
import shlex
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import zlib

from picture import Picture
from qmp import Qmp


def _die_with_parent():
    """QEMU ends with the thread that started it, however that ends (PR_SET_PDEATHSIG); ^C goes to Python alone."""
    ctypes.CDLL(None).prctl(1, signal.SIGKILL, 0, 0, 0)
    os.setpgrp()


class Guest:
    """with Guest(machine, display, initramfs, log) as guest: …; `log` takes what the guest's console says. `arguments` are more
    for QEMU, `append` more for the kernel. A guest that was `saved_as` a file goes on from there. None lives longer than `life`
    seconds."""

    def __init__(self, machine, display, initramfs, log, arguments=(), append="", saved_as=None, life=200):
        self.machine, self.display, self.initramfs, self.log = machine, display, initramfs, log
        self.more, self.append, self.saved_as, self.life = list(arguments), append, saved_as, life
        self.process = self.qmp = self.line = None
        self.commands = 0

    def _arguments(self):
        append = ["panic=-1", "quiet", "random.trust_cpu=on", "audit=0", "apparmor=0", "cryptomgr.notests",
                  "vt.global_cursor_default=0", self.machine.append, self.display.append, self.append]
        sockets = {name: "socket,id=%s,path=%s/%s,server=on,wait=off" % (name, self.folder, name) for name in ("qmp", "shell")}
        return [
            *self.machine.arguments, "-nodefaults", "-no-user-config", "-no-reboot", "-display", "none",
            "-chardev", sockets["qmp"], "-mon", "chardev=qmp,mode=control",
            "-chardev", "file,id=console,path=" + self.log, "-serial", "chardev:console",
            "-chardev", sockets["shell"], *self.machine.shell, *self.machine.boot_arguments(self.display, self.folder),
            "-initrd", self.initramfs, "-append", " ".join(append), *self.display.arguments, *self.more,
            *(["-incoming", "exec:cat " + shlex.quote(self.saved_as)] if self.saved_as else [])]

    def __enter__(self):
        self.folder = tempfile.mkdtemp(prefix="vm")   # a socket's path has at most 107 bytes
        self.errors = open(os.path.join(self.folder, "errors"), "w+")
        try:
            self.process = subprocess.Popen(self._arguments(), stdin=subprocess.DEVNULL, stdout=self.errors, stderr=self.errors,
                                            preexec_fn=_die_with_parent)
            self.watch = threading.Timer(self.life, self.process.kill)
            self.watch.daemon = True
            self.watch.start()
            self.qmp = Qmp(self.folder + "/qmp", lambda: self.process.poll() is None)
            self.line = socket.socket(socket.AF_UNIX)
            self.line.connect(self.folder + "/shell")
            if not self.saved_as:
                self._wait_for_boot()
        except BaseException as error:
            self.errors.seek(0)
            said = self.errors.read().strip()
            self.__exit__()
            if said and isinstance(error, Exception):
                raise RuntimeError("%s; QEMU says: %s" % (error, said)) from error
            raise
        return self

    def __exit__(self, *_):
        if self.process:
            self.watch.cancel()
            self.process.kill()
            self.process.wait()
        for part in (self.qmp and self.qmp.socket, self.line, self.errors):
            if part:
                part.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    def _wait_for_boot(self):
        received, deadline = b"", time.monotonic() + 150
        while b"__OPEN\n" not in received:
            if self.process.poll() is not None or time.monotonic() > deadline:
                raise RuntimeError("the guest does not boot; its console is in " + self.log)
            received += self._receive()

    def _receive(self):
        self.line.settimeout(0.5)
        try:
            received = self.line.recv(65536)
        except socket.timeout:
            return b""
        if not received:
            raise RuntimeError("the guest ended; its console is in " + self.log)
        return received.replace(b"\r", b"")

    def shell(self, command, timeout=30):
        """Runs a command of one line in the guest: (its status, its output)."""
        self.commands += 1
        self.line.sendall(b"%d %s\n" % (self.commands, command.encode()))
        end = re.compile(rb"\n__END%d_(\d+)_\n" % self.commands)
        received, deadline = b"", time.monotonic() + timeout
        while not (found := end.search(received)):
            if time.monotonic() > deadline:
                raise RuntimeError("the guest's command %r is not done in %d s" % (command, timeout))
            received += self._receive()
        return int(found.group(1)), received[:found.start()].decode(errors="replace").strip()

    def press(self, key):
        """A key of the keyboard, by its QKeyCode (right, up, spc), for a tenth of a second."""
        self.qmp("send-key", keys=[{"type": "qcode", "data": key}])

    def screen(self, head=0):
        """What is seen on the screen."""
        path = os.path.join(self.folder, "screen.ppm")
        # The card of a Raspberry Pi is a part of it, and the only one.
        which = {"device": "video0", "head": head} if self.display.has_name else {}
        self.qmp("screendump", filename=path, **which)
        return Picture.from_ppm(path)

    def blocks(self, path, size, first, count):
        """The bytes of some blocks of a device in the guest."""
        status, text = self.shell("dd if=%s bs=%d skip=%d count=%d 2>/dev/null | gzip -1 | base64" % (path, size, first, count))
        if status:
            raise RuntimeError("the guest's %s cannot be read: %s" % (path, text))
        return zlib.decompress(base64.b64decode(text), 31)

    def plug(self, driver, name, **properties):
        self.qmp("device_add", driver=driver, id=name, **properties)

    def unplug(self, name):
        """Pulls a device out, without asking the guest if it is one of USB."""
        self.qmp("device_del", id=name)
        self.qmp.wait_for("DEVICE_DELETED", name)

    def plug_stick(self, name, image, **properties):
        """A USB stick whose content is the file `image`."""
        self.qmp("blockdev-add", driver="raw", node_name=name + "-image", file={"driver": "file", "filename": image})
        self.plug("usb-storage", name, drive=name + "-image", bus="usb.0", **properties)

    def unplug_stick(self, name):
        self.unplug(name)
        self.qmp("blockdev-del", node_name=name + "-image")

    def save_as(self, path):
        """Stops the machine and writes it to a file."""
        self.qmp("stop")
        self.qmp("migrate", uri="exec:cat >" + shlex.quote(path))
        while (state := self.qmp("query-migrate")["status"]) != "completed":
            if state == "failed":
                raise RuntimeError("the machine cannot be saved")
            time.sleep(0.05)

    def go_on(self):
        """Starts the machine that was saved."""
        while self.qmp("query-status")["status"] == "inmigrate":
            time.sleep(0.02)
        self.qmp("cont")

    def cut_power(self):
        self.process.kill()
        self.process.wait()
