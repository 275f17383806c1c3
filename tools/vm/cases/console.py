"""The text console: there again after every end of the program."""
import re
import subprocess

from frame import TEXT, Failed, Frame, check


def switched(case, card, display):
    """Consoles are switched there and back; text is seen after SIGHUP, SIGTERM, and SIGKILL with `restore-console`."""
    with Frame(case, card) as frame:
        frame.console_is(TEXT)
        frame.start(display)
        frame.shows(frame.expected())
        for _ in range(3):
            frame.guest.shell("chvt 2")
            frame.console_is("tty2 is seen: text")
            frame.text_is_seen("tty2")
            frame.guest.shell("chvt 1")
            frame.shows(frame.expected())
        for signal in ("HUP", "TERM"):      # not INT, which sh has its background jobs ignore
            frame.end(signal)
            frame.console_is(TEXT)
            frame.text_is_seen("tty1")
            frame.start(display)
            frame.shows(frame.expected())
        frame.end("KILL")
        frame.console_is("graphics")
        status, words = frame.guest.shell("yurameki restore-console 2>&1")
        check("restore-console: %s" % words, status == 0)
        frame.console_is(TEXT)
        frame.text_is_seen("tty1")


def panicked(case):
    """The show panics: text is seen again, and the panic's message has been said.

    Nothing in the program panics at will. So its code in memory is changed while it runs: a function that is called before every
    frame begins with a jump to one that panics."""
    with Frame(case, "bochs") as frame:
        frame.start("kms")
        frame.shows(frame.expected())
        pid = frame.do("pidof yurameki")
        base = int(frame.do("grep -m1 yurameki /proc/%s/maps" % pid).split("-")[0], 16)
        names = subprocess.run(["nm", "--demangle", frame.machine.binary], capture_output=True, text=True, check=True).stdout
        called = _address(names, "<yurameki::os::evdev::Keyboards as yurameki::input::Buttons>::next_press")
        panics = _address(names, "alloc::raw_vec::capacity_overflow")
        jump = b"\x48\xb8" + (base + panics).to_bytes(8, "little") + b"\xff\xe0"      # mov rax, panics; jmp rax
        octal = "".join("\\%03o" % byte for byte in jump)
        frame.do("kill -STOP %s" % pid)
        frame.do("printf '%s' | dd of=/proc/%s/mem bs=1 seek=%d conv=notrunc 2>&1" % (octal, pid, base + called))
        frame.do("kill -CONT %s" % pid)
        frame.has_ended()
        frame.says("capacity overflow")
        frame.console_is(TEXT)
        frame.text_is_seen("tty1")


def _address(names, name):
    found = re.search(r"(?m)^([0-9a-f]+) [tT] %s$" % re.escape(name), names)
    if not found:
        raise Failed("the program has no function " + name)
    return int(found.group(1), 16)
