"""Pictures of 8-bit RGB: screendumps (PPM) and rendered frames (PNG)."""
import re
import struct
import zlib


class Picture:
    def __init__(self, width, height, rgb):
        self.width, self.height, self.rgb = width, height, bytes(rgb)
        assert len(self.rgb) == width * height * 3

    def __eq__(self, other):
        return (self.width, self.rgb) == (other.width, other.rgb)

    def difference(self, other):
        """In words."""
        if (self.width, self.height) != (other.width, other.height):
            return "%d×%d instead of %d×%d" % (self.width, self.height, other.width, other.height)
        a, b = self.rgb, other.rgb
        places = [i // 3 for i in range(0, len(a), 3) if a[i:i + 3] != b[i:i + 3]]
        if not places:
            return "equal"
        y, x = divmod(places[0], self.width)
        pixel = slice(places[0] * 3, places[0] * 3 + 3)
        return "%d of %d pixels differ, the first at (%d, %d): %s instead of %s" % (
            len(places), len(a) // 3, x, y, tuple(a[pixel]), tuple(b[pixel]))

    def bright_share(self):
        """The share of pixels with more than 100 of 255 of red: a text console has few, but some."""
        return sum(red > 100 for red in self.rgb[::3]) / (self.width * self.height)

    @classmethod
    def from_ppm(cls, path):
        with open(path, "rb") as f:
            ppm = f.read()
        header = re.match(rb"P6\s+(?:#[^\n]*\n)?(\d+)\s+(\d+)\s+255\s", ppm)
        width, height, pixels = int(header.group(1)), int(header.group(2)), ppm[header.end():]
        row, padding = width * 3, -(width * 3) % 4
        if padding and len(pixels) == height * (row + padding):   # QEMU 7 pads rows to 4 bytes, which PPM does not
            pixels = b"".join(pixels[y * (row + padding):][:row] for y in range(height))
        return cls(width, height, pixels[:width * height * 3])

    @classmethod
    def from_png(cls, path):
        """Of the PNGs that the program writes: 8 bits RGB or RGBA, not interlaced (PNG specification, section 9)."""
        with open(path, "rb") as f:
            png = f.read()
        at, packed = 8, b""
        while at < len(png):
            length, kind = struct.unpack(">I4s", png[at:at + 8])
            content = png[at + 8:at + 8 + length]
            if kind == b"IHDR":
                width, height, depth, colour, _, _, interlace = struct.unpack(">IIBBBBB", content)
            elif kind == b"IDAT":
                packed += content
            at += 12 + length
        assert (depth, interlace) == (8, 0) and colour in (2, 6), "not a PNG as the program writes them"
        step = 3 if colour == 2 else 4
        raw, row_length = zlib.decompress(packed), width * step
        rows, above = [], bytes(row_length)
        for start in range(0, len(raw), row_length + 1):
            above = _unfilter(raw[start], bytearray(raw[start + 1:start + 1 + row_length]), above, step)
            rows.append(above if step == 3 else b"".join(above[i:i + 3] for i in range(0, row_length, 4)))
        return cls(width, height, b"".join(rows))

    @classmethod
    def from_memory(cls, size, stride, pixel_format, memory):
        """Of a frame buffer's memory, red in the lowest bits."""
        width, height = size
        rgb = bytearray()
        for start in range(0, height * stride, stride):
            if pixel_format == "BGR565":
                for word, in struct.iter_unpack("<H", memory[start:start + width * 2]):
                    red, green, blue = word & 31, word >> 5 & 63, word >> 11
                    rgb += bytes((red << 3 | red >> 2, green << 2 | green >> 4, blue << 3 | blue >> 2))
            else:
                step = {"BGR888": 3, "XBGR8888": 4}[pixel_format]
                for at in range(start, start + width * step, step):
                    rgb += memory[at:at + 3]
        return cls(width, height, rgb)

    def as_simple_frame_buffer(self):
        """RGB565 as QEMU's Raspberry Pi shows it: it fills channels up with zeroes, and not with their upper bits."""
        masks = bytes(value & 0xF8 for value in range(256)), bytes(value & 0xFC for value in range(256))
        rgb = bytearray(self.rgb)
        for channel, mask in enumerate((masks[0], masks[1], masks[0])):
            rgb[channel::3] = rgb[channel::3].translate(mask)
        return Picture(self.width, self.height, rgb)

    def is_black(self):
        return not any(self.rgb)

    def save_png(self, path):
        def chunk(kind, content):
            return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
        row = self.width * 3
        raw = b"".join(b"\0" + self.rgb[y * row:(y + 1) * row] for y in range(self.height))
        header = struct.pack(">IIBBBBB", self.width, self.height, 8, 2, 0, 0, 0)
        with open(path, "wb") as f:
            f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(raw, 1)) + chunk(b"IEND", b""))


def _unfilter(kind, row, above, step):
    if kind == 2:
        return bytearray((a + b) & 255 for a, b in zip(row, above))
    for x in range(len(row) if kind else 0):
        left, corner = (row[x - step], above[x - step]) if x >= step else (0, 0)
        row[x] = (row[x] + _prediction(kind, left, above[x], corner)) & 255
    return row


def _prediction(kind, left, above, corner):
    if kind == 1:
        return left
    if kind == 3:
        return (left + above) // 2
    guess = left + above - corner   # Paeth
    return min((left, above, corner), key=lambda value: abs(guess - value))
