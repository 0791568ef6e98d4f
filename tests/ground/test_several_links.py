"""Several links to one kite at a time: what comes twice counts once, and one that breaks is missed by nobody."""

import pytest

from ground.errors import NoAnswerError
from ground.link.framing import Message
from ground.session import Session
from protocol import dialect
from sim_bridge.links.link_settings import LinkSettings

FAST, SLOW = LinkSettings(delay_s=0.02), LinkSettings(delay_s=0.5)


class Counter:
    """Counts what a session's observers are told."""

    def __init__(self, session: Session) -> None:
        self.states: list[int] = []
        self.everything = 0
        session.connection.add_observer(self._observe)
        session.connection.add_observer(self._count, everyone=True)

    def _observe(self, time_s: float, message: Message, frame: bytes) -> None:
        if isinstance(message, dialect.MAVLink_kite_state_message):
            self.states.append(message.time_us)

    def _count(self, time_s: float, message: Message, frame: bytes) -> None:
        self.everything += 1


def fly(session: Session, seconds: float) -> None:
    session.connection.wait_until(lambda: False, seconds)


def test_what_comes_over_two_links_counts_once(simulated_kite):
    """50 states a second, each heard twice, half a second apart; none is told twice, none out of order."""
    kite = simulated_kite(links=[FAST, SLOW])
    session = kite.session(print)
    counter = Counter(session)
    fly(session, 20.0)
    assert len(counter.states) == pytest.approx(1000, abs=5)
    assert counter.states == sorted(set(counter.states))
    assert session.connection.statistics.lost == session.connection.statistics.repeated == 0
    for link in session.links.all:
        assert link.statistics.received == pytest.approx(counter.everything, abs=40)
    assert session.connection.round_trip.seconds == pytest.approx(0.06, abs=0.03)


def test_two_bad_links_make_a_better_one(simulated_kite):
    """A third lost on each, independently: a ninth on both together, where a lone link would lose a third."""
    kite = simulated_kite(links=[LinkSettings(delay_s=0.02, loss=1 / 3), LinkSettings(delay_s=0.06, loss=1 / 3)])
    session = kite.session(print)
    fly(session, 60.0)
    together = session.connection.statistics
    assert together.lost / (together.lost + together.received) == pytest.approx(1 / 9, abs=0.02)
    for link in session.links.all:
        alone = link.statistics
        assert alone.lost / (alone.lost + alone.received) == pytest.approx(1 / 3, abs=0.03)


def test_requests_go_where_the_vehicle_is_heard(simulated_kite):
    """The second link hears nothing: it gets our heartbeat once a second, and none of forty requests."""
    kite = simulated_kite(links=[FAST, LinkSettings(delay_s=0.02, loss=1.0)])
    session = kite.session(print)
    fly(session, 5.0)
    heard, silent = (radio.sent for radio in kite.radios)
    for number in range(40):
        session.parameters.set("INNER_P", 1.0 + number / 64.0)
    assert kite.radios[0].sent - heard >= 40
    assert kite.radios[1].sent - silent <= 6


def test_a_link_that_breaks_is_opened_again_and_the_other_carries_on(simulated_kite):
    kite = simulated_kite(links=[FAST, SLOW])
    notices: list[str] = []
    session = kite.session(notices.append)
    kite.radios[0].broken = True
    assert session.parameters.set("INNER_P", 2.0) == 2.0
    assert notices == ["link simulated: serial port disconnected; retrying every 1 s"]
    kite.radios[0].broken = False
    fly(session, 3.0)
    assert notices[1:] == ["link simulated: back"]
    assert session.links.all[0].hears(kite.clock())
    fly(session, 60.0)
    assert session.connection.round_trip.seconds == pytest.approx(0.06, abs=0.03)


def test_a_vehicle_that_falls_silent_is_waited_for_and_found_again(simulated_kite):
    """The only cable is pulled out: a request ends in words, and works again once the cable is back, by itself."""
    kite = simulated_kite(links=[FAST])
    session = kite.session(lambda text: None)
    kite.radios[0].broken = True
    started_s = kite.clock()
    with pytest.raises(NoAnswerError,
                       match=r"^INNER_P: no answer in \d+ s: the link is down \(.*serial port disconnected\)$"):
        session.parameters.fetch("INNER_P")
    assert kite.clock() - started_s < 15.0
    kite.radios[0].broken = False
    assert session.parameters.fetch("INNER_P") == 1.5


def test_a_kite_that_is_started_anew_is_followed(simulated_kite):
    """Its messages are numbered from 0 again, and its clock begins anew: neither takes it for an echo of the past."""
    kite = simulated_kite(links=[FAST, SLOW])
    session = kite.session(print)
    session.commander.arm()
    fly(session, 3.0)
    kite.start()
    fly(session, 3.0)
    assert session.state.armed is False and session.state.mode == dialect.KITE_MODE_STANDBY
    assert session.connection.vehicle_clock and session.connection.vehicle_clock.uptime_s < 3.1
