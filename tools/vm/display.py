"""A graphics card: QEMU's arguments, the kernel's, the modules, and whether the firmware must start the kernel."""
import struct


class Display:
    VESA_MODES = {"vesa16": 0x314, "vesa24": 0x315}   # of 800×600

    def __init__(self, name, size):
        width, height = self.size = size
        at_size = "xres=%d,yres=%d" % size
        std = ["-device", "VGA,id=video0,edid=on,vgamem_mb=32," + at_size]
        virtio = "virtio-gpu-pci,id=video0,edid=on," + at_size
        self.arguments, self.append, self.modules, self.by_firmware = [], "", [], False
        # Bits of a pixel, where there is no screen: the card is memory alone.
        self.memory_depth = int(name[3:]) if name.startswith("vfb") else None
        self.has_name = name != "simple"
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
        elif self.memory_depth:         # the virtual driver: red in the lowest bits, and any size
            self.modules = ["vfb"]
            self.append = "vfb.vfb_enable=1 vfb.videomemorysize=%d" % (1 << 22)
        elif name == "simple":          # what the firmware of a Raspberry Pi leaves, in RGB565
            self.arguments = ["-global", "bcm2835-fb.xres=%d" % width, "-global", "bcm2835-fb.yres=%d" % height]
        else:
            raise ValueError("no display %r" % name)

    def set_size(self):
        """The shell's command that sets the size of a card that is memory alone. The list of modes that sysfs takes is one of
        `struct fb_videomode` (linux/fb.h): a pointer, thirteen 32-bit numbers and padding. It is taken, but the kernel answers that
        it has taken nothing of it, so that printf tries again until it is ended."""
        width, height = self.size
        mode = struct.pack("<Q14I", 0, 60, width, height, 39721, 40, 24, 32, 11, 96, 2, 0, 0, 0, 0)
        octal = "".join("\\%03o" % byte for byte in mode)
        return "cd /sys/class/graphics/fb0; timeout 1 printf '%s' >modes; echo U:%dx%dp-60 >mode && echo %d >bits_per_pixel" % (
            octal, width, height, self.memory_depth)
