"""A virtual machine: a Debian kernel under QEMU, its shell by a serial line, its keys and its screen by QMP.

Plain emulation (TCG) only: three seconds to boot, and the same everywhere. /dev/kvm may be there and yet be unable to run a stock
kernel, as within some virtual machines."""
import ctypes
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time

from picture import Picture

QEMU = "qemu-system-x86_64"
# No case takes a minute: a machine that hangs is ended after so many seconds.
LONGEST_LIFE = 200


class Qmp:
    """QEMU's control socket (QEMU Machine Protocol)."""

    def __init__(self, path, is_alive):
        deadline = time.monotonic() + 10
        while True:
            self.socket = socket.socket(socket.AF_UNIX)
            try:
                self.socket.connect(path)
                break
            except OSError:
                self.socket.close()
                if not is_alive() or time.monotonic() > deadline:
                    raise RuntimeError("QEMU's control socket does not answer") from None
                time.sleep(0.01)
        self.socket.settimeout(30)
        self.lines = self.socket.makefile("rb")
        self.lines.readline()
        self("qmp_capabilities")

    def __call__(self, command, **arguments):
        self.socket.sendall(json.dumps({"execute": command, "arguments": arguments}).encode() + b"\n")
        while line := self.lines.readline():
            answer = json.loads(line)
            if "error" in answer:
                raise RuntimeError("%s: %s" % (command, answer["error"]["desc"]))
            if "return" in answer:
                return answer["return"]
        raise RuntimeError("QEMU ended")


class Display:
    """A graphics card: QEMU's arguments, the kernel's, the modules, and whether the firmware must start the kernel."""

    VESA_MODES = {"vesa16": 0x314, "vesa24": 0x315}   # of 800×600

    def __init__(self, name, size):
        width, height = size
        at_size = "xres=%d,yres=%d" % size
        std = ["-device", "VGA,id=video0,edid=on,vgamem_mb=32," + at_size]
        virtio = "virtio-gpu-pci,id=video0,edid=on," + at_size
        self.arguments, self.append, self.modules, self.by_firmware = [], "", [], False
        if name == "bochs":
            assert width % 8 == 0, "QEMU's VGA rounds the width down to a multiple of 8 and shows the rest sheared"
            self.arguments, self.modules = std, ["bochs"]
        elif name == "virtio":
            self.arguments, self.modules = ["-device", virtio], ["virtio_pci", "virtio_gpu"]
        elif name == "virtio-padded":   # a second, wider head makes the lines of the shared frame buffer longer than shown
            self.arguments, self.modules = ["-device", virtio + ",max_outputs=2"], ["virtio_pci", "virtio_gpu"]
            self.append = "video=Virtual-2:%dx%de" % (width + 222, height)
        elif name in self.VESA_MODES:
            assert size == (800, 600)
            self.arguments, self.by_firmware = std, True
            self.append = "vga=0x%x" % self.VESA_MODES[name]
        elif name == "cirrus":          # the DRM driver, whose frame buffer device is RGB565
            self.arguments, self.modules = ["-device", "cirrus-vga,id=video0"], ["cirrus"]
            self.append = "video=%dx%d" % size
        elif name == "cirrusfb":        # the old driver, which pans
            self.arguments, self.modules = ["-device", "cirrus-vga,id=video0"], ["cirrusfb"]
            self.append = "cirrusfb.mode_option=%dx%d-16@60" % size
        else:
            raise ValueError("no display %r" % name)


def _die_with_parent():
    """QEMU ends with the thread that started it, however that ends (PR_SET_PDEATHSIG); ^C goes to Python alone."""
    ctypes.CDLL(None).prctl(1, signal.SIGKILL, 0, 0, 0)
    os.setpgrp()


class Guest:
    """with Guest(kernel, initramfs, Display(…), log) as guest: …; `log` takes what the guest's console says."""

    def __init__(self, kernel, initramfs, display, log):
        self.kernel, self.initramfs, self.display, self.log = kernel, initramfs, display, log
        self.process = self.qmp = self.line = None
        self.commands = 0

    def _arguments(self):
        unpacked = os.path.join(self.kernel, "vmlinux")
        packed = os.path.join(self.kernel, "vmlinuz")
        append = ["panic=-1", "quiet", "random.trust_cpu=on", "audit=0", "apparmor=0", "cryptomgr.notests", "mitigations=off",
                  "no_timer_check", "vt.global_cursor_default=0", "console=ttyS0", self.display.append]
        sockets = {name: "socket,id=%s,path=%s/%s,server=on,wait=off" % (name, self.folder, name) for name in ("qmp", "shell")}
        return [
            # The emulated time stamp counter is the host's, whose rate a loaded guest measures wrong; without it the guest goes by
            # QEMU's own clock.
            QEMU, "-accel", "tcg", "-M", "q35", "-cpu", "qemu64,-tsc", "-m", "384",
            "-nodefaults", "-no-user-config", "-no-reboot", "-display", "none",
            "-chardev", sockets["qmp"], "-mon", "chardev=qmp,mode=control",
            "-chardev", "file,id=console,path=" + self.log, "-serial", "chardev:console",
            "-chardev", sockets["shell"], "-serial", "chardev:shell",
            "-kernel", packed if self.display.by_firmware or not os.path.exists(unpacked) else unpacked,
            "-initrd", self.initramfs, "-append", " ".join(append).strip(), *self.display.arguments]

    def __enter__(self):
        self.folder = tempfile.mkdtemp(prefix="vm")   # a socket's path has at most 107 bytes
        self.errors = open(os.path.join(self.folder, "errors"), "w+")
        try:
            self.process = subprocess.Popen(self._arguments(), stdin=subprocess.DEVNULL, stdout=self.errors, stderr=self.errors,
                                            preexec_fn=_die_with_parent)
            self.watch = threading.Timer(LONGEST_LIFE, self.process.kill)
            self.watch.daemon = True
            self.watch.start()
            self.qmp = Qmp(self.folder + "/qmp", lambda: self.process.poll() is None)
            self.line = socket.socket(socket.AF_UNIX)
            self.line.connect(self.folder + "/shell")
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
        self.qmp("screendump", filename=path, device="video0", head=head)
        return Picture.from_ppm(path)
