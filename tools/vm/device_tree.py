"""Editing a compiled device tree (Devicetree Specification 0.4, chapter 5)."""
import struct

BEGIN_NODE, END_NODE, PROPERTY = 1, 2, 3
MAGIC = 0xD00DFEED
# Where QEMU's Raspberry Pi shows its memory from after a reset: the base of the video memory, and 1 MiB.
SCANNED_OUT = 0x3C100000


def with_frame_buffer(tree, size):
    """`tree` with the node that a Raspberry Pi's firmware adds under /chosen: an RGB565 frame buffer of `size`."""
    (magic, _, structure_at, strings_at, reserved_at, _, _, cpu, strings_length, structure_length) = struct.unpack(
        ">10I", tree[:40])
    assert magic == MAGIC
    structure = tree[structure_at:structure_at + structure_length]
    strings = bytearray(tree[strings_at:strings_at + strings_length])
    reserved = tree[reserved_at:structure_at]

    def cells(*values):
        return struct.pack(">%dI" % len(values), *values)

    def padded(value):
        return value + b"\0" * (-len(value) % 4)

    def property_(name, value):
        at = len(strings)
        strings.extend(name.encode() + b"\0")
        return cells(PROPERTY, len(value), at) + padded(value)

    width, height = size
    properties = property_("#address-cells", cells(1)) + property_("#size-cells", cells(1)) + property_("ranges", b"")
    node = (cells(BEGIN_NODE) + padded(b"framebuffer@%x\0" % SCANNED_OUT) + property_("compatible", b"simple-framebuffer\0")
            + property_("reg", cells(SCANNED_OUT, width * height * 2)) + property_("width", cells(width))
            + property_("height", cells(height)) + property_("stride", cells(width * 2)) + property_("format", b"r5g6b5\0")
            + cells(END_NODE))
    # Properties come before nodes: both are put where they may be, at the two ends of /chosen, which has no nodes.
    begin = cells(BEGIN_NODE) + b"chosen\0\0"
    start = structure.index(begin) + len(begin)
    end = _end_of_properties(structure, start)
    structure = structure[:end] + properties + node + structure[end:]
    strings_at = 40 + len(reserved) + len(structure)
    header = cells(MAGIC, strings_at + len(strings), 40 + len(reserved), strings_at, 40, 17, 16, cpu, len(strings), len(structure))
    return header + reserved + structure + bytes(strings)


def _end_of_properties(structure, at):
    while struct.unpack_from(">I", structure, at)[0] == PROPERTY:
        length, = struct.unpack_from(">I", structure, at + 4)
        at += 12 + (length + 3 & ~3)
    return at
