"""The light: each state has a pattern that nothing else has, and showing it never waits."""

import pytest

from firmware_py.boards import light
from firmware_py.boards.light import StatusLight
from firmware_py.generated_enums import KITE_MODE_MANUAL, KITE_MODE_PARK, KITE_MODE_STANDBY, KITE_MODE_TRACK

SLOT_US = 1 << 17
ROUND_US = 16 * SLOT_US
NAMES = ("NO_LINK", "SETTINGS", "STOPPED", "NOT_STORED", "DISARMED", "STALE", "MANUAL", "PARK", "TRACK")


class Watched:
    """A light and who looks at it."""

    def __init__(self, linked: bool = True):
        self.received = 0
        self.level = 0
        self.writes = 0
        self.light = StatusLight(self._pin, lambda: self.received)
        if linked:
            self.received = 1

    def _pin(self, level: int) -> None:
        self.level = level
        self.writes += 1

    def pattern(self, mode: int, stale: bool = False, start: int = 0, talking: bool = True) -> int:
        """What is seen of one round, slot by slot, looking each 20 ms."""
        seen = 0
        for now in range(start, start + ROUND_US, 20_000):
            self.received += talking
            self.light.show(mode, stale, now % (1 << 30))
            seen |= self.level << (now % ROUND_US // SLOT_US)
        return seen


def turned(pattern: int) -> set[int]:
    return {(pattern << by | pattern >> (16 - by)) & 0xFFFF for by in range(16)}


def test_no_two_patterns_look_alike_whenever_one_begins_to_look():
    patterns = [getattr(light, name) for name in NAMES]
    for pattern in patterns:
        assert sum(pattern in turned(other) for other in patterns) == 1


@pytest.mark.parametrize(("mode", "stale", "pattern"), [
    (KITE_MODE_STANDBY, False, light.DISARMED), (KITE_MODE_MANUAL, False, light.MANUAL),
    (KITE_MODE_PARK, False, light.PARK), (KITE_MODE_TRACK, False, light.TRACK),
    (KITE_MODE_TRACK, True, light.STALE), (KITE_MODE_PARK, True, light.STALE)])
def test_each_state_shows_its_pattern(mode, stale, pattern):
    watched = Watched()
    assert watched.pattern(mode, stale) == pattern
    assert watched.pattern(mode, stale, start=ROUND_US) == pattern
    assert watched.writes <= 34  # twice a slot at most: a wireless board's light is slow to reach


def test_the_gaps_of_an_armed_kite_count_its_mode():
    for mode, pattern in ((1, light.MANUAL), (2, light.PARK), (3, light.TRACK)):
        dark = f"{~pattern & 0xFFFF:016b}"
        assert len([gap for gap in dark.split("0") if gap]) == mode


def test_storage_that_fails_is_shown_on_the_ground_only():
    watched = Watched()
    failing = [True]
    watched.light.ask_storage(lambda: failing[0])
    assert watched.pattern(KITE_MODE_STANDBY) == light.NOT_STORED
    assert watched.pattern(KITE_MODE_TRACK) == light.TRACK
    failing[0] = False
    assert watched.pattern(KITE_MODE_STANDBY) == light.DISARMED


def test_the_link_is_missed_after_three_seconds_and_seen_again_at_once():
    watched = Watched(linked=False)
    assert watched.pattern(KITE_MODE_STANDBY, talking=False) == light.NO_LINK
    watched.received += 1
    watched.light.show(KITE_MODE_STANDBY, False, 10_000_000)
    assert watched.pattern(KITE_MODE_STANDBY, start=10_000_000 // ROUND_US * ROUND_US) == light.DISARMED
    last = 10_000_000 // ROUND_US * ROUND_US + ROUND_US
    for now in range(last, last + 4_000_000, 20_000):
        watched.light.show(KITE_MODE_STANDBY, False, now)
    assert watched.pattern(KITE_MODE_STANDBY, start=5 * ROUND_US + last, talking=False) == light.NO_LINK
    for second in range(1200):  # the clock wraps meanwhile
        watched.light.show(KITE_MODE_STANDBY, False, second * 1_000_000 % (1 << 30))
    assert watched.pattern(KITE_MODE_STANDBY, talking=False) == light.NO_LINK


def test_the_clock_wraps_between_two_rounds():
    assert (1 << 30) % ROUND_US == 0


def test_an_armed_kite_looks_armed_whoever_talks_to_it():
    watched = Watched(linked=False)
    assert watched.pattern(KITE_MODE_TRACK, talking=False) == light.TRACK
