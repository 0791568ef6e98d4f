"""The monitor: what it warns of, and that it fits the terminal that it is in."""

import fcntl
import os
import pty
import struct
import termios
import threading

import pytest

from ground.cli.monitor import monitor
from ground.cli.monitor_view import screen
from ground.health import Advisor
from sim_bridge.links.link_settings import LinkSettings


def fly(session, seconds: float) -> None:
    session.connection.wait_until(lambda: False, seconds)


def test_a_good_flight_on_a_good_link_needs_no_warning(flying_kite):
    session = flying_kite("small-kite").session(print)
    advisor = Advisor(session)
    for _ in range(10):
        fly(session, 2.0)
        assert advisor.warnings() == []


def test_it_warns_of_losses_of_a_way_up_that_is_gone_and_of_silence(simulated_kite):
    """A link that loses a quarter; then nothing goes up; then nothing comes down; then the link is well again."""
    kite = simulated_kite(loss=0.25, round_trip_s=0.1)
    session = kite.session(print)
    advisor = Advisor(session)
    fly(session, 10.0)
    lossy = advisor.warnings()[0]  # and it hangs still, which is another matter
    assert "of the messages are lost: move closer, turn the antenna, or lower STATE_HZ" in lossy
    kite.change_link(down=LinkSettings(), up=LinkSettings(loss=1.0))
    fly(session, 20.0)
    unheard = advisor.warnings()[0]
    assert "the kite has not answered for 2" in unheard and "add another --link" in unheard
    kite.change_link(down=LinkSettings(loss=1.0), up=LinkSettings())
    fly(session, 20.0)
    (silent,) = advisor.warnings()
    assert silent.startswith("NO MESSAGE FOR 20 s, all values below are old: check the kite's power")
    assert screen(session, [silent], 80, 24)[1].startswith("! NO MESSAGE FOR 20 s")
    kite.change_link(down=LinkSettings(), up=LinkSettings())
    fly(session, 10.0)
    assert ["the kite is too slow to measure its course" in text for text in advisor.warnings()] == [True]


def test_it_warns_of_a_turning_angle_that_swings(flying_kite):
    session = flying_kite("paper-delay").session(print)
    advisor = Advisor(session)
    fly(session, 30.0)
    assert any("lower INNER_P (kite-ground tune), or go to PARK" in text for text in advisor.warnings())


def test_silence_is_told_before_anything_else_and_soon(flying_kite):
    """Fifty states a second, and then none for a second: whatever the flight did last, that is what is told."""
    kite = flying_kite("paper-delay", round_trip_s=0.02)
    session = kite.session(print)
    advisor = Advisor(session)
    fly(session, 30.0)
    kite.change_link(down=LinkSettings(loss=1.0), up=LinkSettings())
    fly(session, 0.5)
    assert not any("NO MESSAGE" in text for text in advisor.warnings())
    fly(session, 0.7)
    (silent,) = advisor.warnings()
    assert silent.startswith("NO MESSAGE FOR 1.2 s, all values below are old")


def test_a_firmware_that_stood_still_is_not_told_to_lower_its_gain(flying_kite):
    """The kite flies on for 3 s without its firmware, and is far off the target then: that is not the gain's doing.
    A link that is gone for as long is not taken for it, and blames nobody."""
    kite = flying_kite("small-kite-paper", round_trip_s=0.02)
    session = kite.session(print)
    advisor = Advisor(session)
    fly(session, 10.0)
    kite.change_link(down=LinkSettings(loss=1.0), up=LinkSettings())
    fly(session, 2.0)
    kite.change_link(down=LinkSettings(delay_s=0.01), up=LinkSettings(delay_s=0.01))
    fly(session, 3.0)
    assert not any("stood still" in text for text in advisor.warnings())
    fly(session, 10.0)
    kite.suspend_firmware(3.0)
    fly(session, 0.5)
    assert advisor.warnings()[0].startswith("the firmware stopped for 3.")
    for _ in range(9):
        fly(session, 0.5)
        assert not any("INNER_P" in text for text in advisor.warnings())
    fly(session, 20.0)
    assert advisor.warnings() == []


@pytest.mark.parametrize("what", ["values", "stamps"])
def test_sensors_that_stand_still_are_told(flying_kite, what):
    """The same values with new stamps, or the same stamp with other values: neither is a flight."""
    kite = flying_kite("small-kite", round_trip_s=0.02)
    session = kite.session(print)
    advisor = Advisor(session)
    fly(session, 10.0)
    assert advisor.warnings() == []
    kite.freeze_sensors(what)
    fly(session, 1.7)
    told = advisor.warnings()
    assert any("position frozen for" in text or "samples are stale" in text for text in told)
    assert not any("INNER_P" in text for text in told)


@pytest.mark.parametrize(("width", "height"), [(80, 24), (120, 40), (40, 10), (20, 3)])
def test_the_screen_fits(flying_kite, width, height):
    session = flying_kite("small-kite").session(print)
    fly(session, 3.0)
    lines = screen(session, ["a long warning that goes on and on, and then on"], width, height)
    assert len(lines) <= height and max(map(len, lines)) <= width
    if height >= 24:
        text = "\n".join(lines)
        for words in ("TRACK", "cross-track", "turning angle", "target", "steering", "airspeed", "loop", "overruns",
                      "link", "lost", "round trip", "90 %", "messages, newest first"):
            assert words in text


def test_it_follows_a_terminal_that_is_resized(flying_kite):
    """A real pseudo-terminal, 80 columns and then 30: no line is longer after that, and the screen was wiped once."""
    session = flying_kite("small-kite").session(print)
    ours, theirs = pty.openpty()
    heard = bytearray()

    def resize(rows: int, columns: int) -> None:
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def read() -> None:
        while b"the end" not in heard:
            heard.extend(os.read(ours, 4096))

    reader = threading.Thread(target=read)
    reader.start()
    with os.fdopen(theirs, "w") as output:
        resize(24, 80)
        monitor(session, output, 1.0)
        output.write("resized")
        resize(12, 30)
        monitor(session, output, 1.0)
        output.write("the end")
        output.flush()
        reader.join()
    os.close(ours)
    wide, _, narrow = heard.decode().partition("resized")
    assert "turning angle" in wide and wide.count("\x1b[2J") == narrow.count("\x1b[2J") == 1
    rows = [line.replace("\x1b[H", "").split("\x1b[K")[0] for line in narrow.split("\r\n")[1:]]
    assert max(len(row) for row in rows) <= 30 < max(len(row.split("\x1b[K")[0]) for row in wide.split("\r\n"))
