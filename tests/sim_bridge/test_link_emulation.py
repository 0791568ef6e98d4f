"""The emulated radio link: exact where it is exact, with the right statistics where it is random."""

from itertools import pairwise

import pytest

from sim_bridge.links.emulation import LinkDirection
from sim_bridge.links.link_settings import LinkSettings
from sim_bridge.scenario.scenario import Scenario


def due(link, until_s):
    """(time out, item) of everything that has come out."""
    return [(parcel.time_s, parcel.item) for parcel in link.due(until_s)]


def sent_through(settings, count=20000, period=0.02, size=50, seed="1"):
    """(index, time in, time out) of everything that comes out."""
    link = LinkDirection(settings, seed)
    for index in range(count):
        link.send(index * period, index, size)
    return [(index, index * period, out) for out, index in due(link, 1e9)]


def test_a_plain_delay_is_exact_and_comes_out_in_order_and_not_before():
    link = LinkDirection(LinkSettings(delay_s=0.1), "1")
    link.send(0.0, "a", 1)
    assert due(link, 0.0999) == []
    assert due(link, 0.1) == [(0.1, "a")]


def test_jitter_is_uniform_about_the_delay_and_never_negative():
    delays = [out - put for _, put, out in sent_through(LinkSettings(delay_s=0.05, jitter_s=0.03))]
    assert 0.02 <= min(delays) < 0.0205 and 0.0795 < max(delays) <= 0.08
    assert sum(delays) / len(delays) == pytest.approx(0.05, abs=0.001)
    assert min(out - put for _, put, out in sent_through(LinkSettings(jitter_s=0.03))) == pytest.approx(0.0)


@pytest.mark.parametrize(("loss", "burst"), [(0.05, 0.0), (0.2, 5.0), (0.5, 20.0)])
def test_losses_have_the_share_and_the_bursts_asked_for(loss, burst):
    got = {index for index, _, _ in sent_through(LinkSettings(loss=loss, loss_burst=burst), count=100000)}
    lost = [index not in got for index in range(100000)]
    assert sum(lost) / len(lost) == pytest.approx(loss, rel=0.1)
    bursts = sum(1 for before, here in pairwise(lost) if here and not before)
    expected = burst if burst > 1 else 1.0 / (1.0 - loss)
    assert sum(lost) / bursts == pytest.approx(expected, rel=0.1)


def test_everything_lost_is_everything_lost():
    assert sent_through(LinkSettings(loss=1.0)) == []
    assert sent_through(LinkSettings(loss=1.0, loss_burst=10.0)) == []


def test_duplicates_and_overtaking():
    out = sent_through(LinkSettings(delay_s=0.1, duplicate=0.1, reorder=0.1, reorder_s=0.05))
    assert len(out) == pytest.approx(22000, rel=0.03)
    order = [index for index, _, _ in out]
    assert order != sorted(order)
    assert set(order) == set(range(20000))


def test_a_slow_link_carries_its_rate_and_drops_what_waits_too_long():
    out = sent_through(LinkSettings(rate_bytes_s=1250.0), count=1000)  # half of the 2500 bytes/s that are sent
    last = max(time for _, _, time in out)
    assert len(out) * 50 / last == pytest.approx(1250.0, rel=0.01)
    assert max(time - put for _, put, time in out) < 1.1


def test_one_seed_repeats():
    settings = LinkSettings(delay_s=0.1, jitter_s=0.05, loss=0.2)
    assert sent_through(settings) == sent_through(settings) != sent_through(settings, seed="2")


@pytest.mark.parametrize(("delay", "down", "up"), [(0.2, 0.1, 0.1), (0.05, 0.02, 0.03), (0.01, 0.0, 0.01), (0, 0, 0)])
def test_the_control_paths_delay_is_split_in_whole_periods_for_the_samples(delay, down, up):
    scenario = Scenario("test")
    scenario.set("link.control.delay_s", delay, "test")
    control = scenario.link.control
    assert (control.down.delay_s, control.up.delay_s) == pytest.approx((down, up))


def test_a_direction_of_its_own_wins():
    scenario = Scenario("test")
    scenario.set("link.ground.delay_s", 1.0, "test")
    scenario.set("link.ground.loss", 0.2, "test")
    scenario.set("link.ground.up.delay_s", 0.1, "test")
    scenario.set("link.ground.down.loss", 0.0, "test")
    down, up = scenario.link.ground
    assert (down.delay_s, down.loss, up.delay_s, up.loss) == (0.5, 0.0, 0.1, 0.2)
