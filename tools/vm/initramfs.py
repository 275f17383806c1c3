"""The guest's root file system: one uncompressed newc cpio (Linux, Documentation/driver-api/early-userspace/buffer-format.rst)
with busybox, kernel modules, and the files of a test. Needs neither root nor the cpio tool."""
import os
import re
import stat

HERE = os.path.dirname(os.path.abspath(__file__))


class Cpio:
    def __init__(self):
        self.entries = {}

    def folder(self, name):
        parts = name.split("/")
        for end in range(1, len(parts) + 1):
            self.entries.setdefault("/".join(parts[:end]), (stat.S_IFDIR | 0o755, b"", 0, 0))

    def _put(self, name, *entry):
        if "/" in name:
            self.folder(os.path.dirname(name))
        self.entries[name] = entry

    def file(self, name, content, mode=0o644):
        self._put(name, stat.S_IFREG | mode, content, 0, 0)

    def device(self, name, mode, major, minor):
        self._put(name, stat.S_IFCHR | mode, b"", major, minor)

    def link(self, name, target):
        self._put(name, stat.S_IFLNK | 0o777, target.encode(), 0, 0)

    def write(self, path):
        out = bytearray()
        entries = sorted(self.entries.items()) + [("TRAILER!!!", (0, b"", 0, 0))]
        for inode, (name, (mode, content, major, minor)) in enumerate(entries, 1):
            name = name.encode() + b"\0"
            fields = inode, mode, 0, 0, 1, 0, len(content), 0, 0, major, minor, len(name), 0
            for part in (b"070701" + b"%08X" * 13 % fields + name, content):
                out += part
                out += b"\0" * (-len(out) % 4)
        with open(path, "wb") as f:
            f.write(out)


# What a driver asks modprobe for, and nothing but insmod is here.
SOFT_DEPENDENCIES = {"virtio_gpu": ["virtio_dma_buf"]}


def load_order(kernel, wanted):
    """[(name, path)] of the wanted modules and what they depend on, dependencies first; without what is built in."""
    with open(os.path.join(kernel, "version")) as f:
        base = os.path.join(kernel, "root/lib/modules", f.read().strip())

    def name_of(path):
        return re.sub(r"\.ko$", "", os.path.basename(path)).replace("-", "_")

    needs, paths, order = {}, {}, []
    with open(os.path.join(base, "modules.dep")) as f:
        for line in f:
            path, _, rest = line.partition(":")
            needs[name_of(path)] = [name_of(p) for p in rest.split()]
            paths[name_of(path)] = os.path.join(base, path)
    with open(os.path.join(base, "modules.builtin")) as f:
        built_in = {name_of(line.strip()) for line in f}

    def visit(name):
        if name in built_in or name in order:
            return
        if name not in needs:
            raise RuntimeError("the kernel has no module %r" % name)
        for other in needs[name][::-1] + [n for n in SOFT_DEPENDENCIES.get(name, []) if n in needs]:
            visit(other)
        order.append(name)

    for name in wanted:
        visit(name)
    return [(name, paths[name]) for name in order]


def build(kernel, out, modules, files):
    """Writes the file `out`; `files` is {path in the guest: path here, or the bytes themselves}."""
    def read(path):
        with open(path, "rb") as f:
            return f.read()

    cpio = Cpio()
    for name in ("proc", "sys", "dev", "tmp", "root"):
        cpio.folder(name)
    cpio.device("dev/console", 0o600, 5, 1)
    cpio.device("dev/null", 0o666, 1, 3)
    cpio.file("bin/busybox", read(os.path.join(kernel, "busybox")), 0o755)
    cpio.link("bin/sh", "busybox")
    cpio.file("init", read(os.path.join(HERE, "init.sh")), 0o755)
    for name, content in files.items():
        if isinstance(content, bytes):
            cpio.file(name, content)
        else:
            cpio.file(name, read(content), os.stat(content).st_mode & 0o777)
    order = load_order(kernel, modules)
    for name, path in order:
        cpio.file("lib/modules/%s.ko" % name, read(path))
    cpio.file("etc/modules", "".join(name + "\n" for name, _ in order).encode())
    cpio.write(out)
