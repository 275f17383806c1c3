#!/usr/bin/env python3
"""extract_vmlinux.py BZIMAGE OUT: the xz-compressed ELF kernel out of an x86 bzImage (payload_offset and payload_length of its
setup header: Linux, Documentation/arch/x86/boot.rst)."""
import lzma
import struct
import sys

d = open(sys.argv[1], "rb").read()
if d[0x202:0x206] != b"HdrS":
    sys.exit("not an x86 bzImage: no vmlinux extracted")
start = (d[0x1F1] + 1) * 512
off, length = struct.unpack_from("<II", d, 0x248)
p = d[start + off:start + off + length]
if p[:6] != b"\xfd7zXZ\0":
    sys.exit("payload is not xz: %r" % p[:6])
out = lzma.LZMADecompressor(format=lzma.FORMAT_XZ).decompress(p)
if out[:4] != b"\x7fELF":
    sys.exit("payload is not ELF")
open(sys.argv[2], "wb").write(out)
