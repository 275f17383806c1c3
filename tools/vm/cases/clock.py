"""The clock of a board that has none."""
from frame import Frame


def wrong(case):
    """The guest wakes up in 1970, with a schedule by which the panel is off all day. Nothing happens before somebody has set the
    clock and says so."""
    settings = '[night]\ntimes = ["00:00 off"]\nzone = "UTC0"\n'
    with Frame(case, "bochs", arguments=["-rtc", "base=1970-01-01T00:00:00"], settings=settings) as frame:
        frame.wait("a clock in 1970", 1, lambda: frame.do("date +%Y") == "1970")
        frame.start("kms")
        frame.shows(frame.expected())
        frame.do("date -s '2026-11-01 12:00'")
        frame.shows(frame.expected())
        # What systemd-timesyncd does once a server has told the time.
        frame.do("mkdir -p /run/systemd/timesync; touch /run/systemd/timesync/synchronized")
        frame.is_black()
        frame.says("the panel goes to off")
        frame.guest.press("right")
        frame.shows(frame.expected())
