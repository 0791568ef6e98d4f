"""The steering already sent, and the actuator's model that goes through it, against the bridge's actuator."""

import random

import pytest
from eights import parameters
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_py.prediction.steering_history import ONE, ROOM, SteeringHistory
from sim_bridge.equipment.actuator import Actuator
from sim_bridge.equipment.actuator_settings import ActuatorSettings

PERIOD_S = 0.02
FINE = 200  # steps in a tick, for the reference's integrals
commands = st.lists(st.floats(-1.0, 1.0), min_size=8, max_size=40)


def history(asked, **changed: float) -> SteeringHistory:
    """A history of the steering `asked`, oldest first, for the actuator that the parameters describe."""
    made = SteeringHistory()
    made.load(parameters(**changed))
    for steering in asked:
        made.note(steering, 1)
    return made


def actuator(rate: float, saturation: float) -> Actuator:
    return Actuator(ActuatorSettings(rate_limit_per_s=rate, saturation=saturation))


def flown(part: Actuator, steering: float, ticks: float) -> list[float]:
    """Positions of the actuator in the middle of fine steps over `ticks` of `steering`."""
    part.command(0.0, steering)
    part.apply_due(0.0)
    positions = []
    for _ in range(round(FINE * ticks)):
        part.advance(0.5 * PERIOD_S / FINE)
        positions.append(part.position)
        part.advance(0.5 * PERIOD_S / FINE)
    return positions


@settings(deadline=None, max_examples=60)
@given(commands, st.sampled_from([0.0, 0.25, 4.0, 30.0]), st.sampled_from([0.0, 0.375, 1.0]), st.integers(0, 6),
       st.sampled_from([0.0, 0.25, 0.5]), st.booleans())
def test_it_is_where_the_actuator_is_and_did_what_it_did(asked, rate, saturation, whole, partial, tail):
    """Position, integral and first moment about the middle, over a part of a tick, whole ones, and half of one."""
    ticks = whole + (1 if partial else 0)
    part = actuator(rate, saturation)
    before, after = asked[: len(asked) - ticks], asked[len(asked) - ticks :]
    for steering in before:
        flown(part, steering, 1.0)
    path = []
    if partial:
        flown(part, after[0], 1.0 - partial)
        path += flown(part, after[0], partial)
    for steering in after[1 if partial else 0 :]:
        path += flown(part, steering, 1.0)
    if tail:
        path += flown(part, asked[-1], 0.5)

    made = history(asked, PRED_RATE=rate, PRED_SAT=saturation)
    made.begin(ticks, partial, None)
    made.advance(partial, whole, 0.5 if tail else 0.0)
    middle = 0.5 * len(path)
    jump = 1.0 / FINE  # without a rate limit the reference knows a jump's time to half a step
    assert made.position / ONE == pytest.approx(part.position, abs=2e-4)
    assert made.total / ONE == pytest.approx(sum(path) / FINE, abs=3e-4)
    moment = sum(p * (i + 0.5 - middle) for i, p in enumerate(path)) / FINE**2
    assert made.moment / ONE == pytest.approx(moment, abs=1e-3 + jump * 1e-2)


def swings(seed: int, ticks: int) -> list[float]:
    """Steering that leans to one side, with stretches at rest, ramps and jumps: what a flight asks for."""
    chance = random.Random(seed)
    asked, value = [], 0.0
    while len(asked) < ticks:
        slope = chance.choice((0.0, 0.003, -0.003, 0.2))
        value = chance.choice((value, 0.5 + 0.4 * chance.random(), -0.3))
        for _ in range(chance.randint(1, 30)):
            value = max(-1.0, min(1.0, value + slope))
            asked.append(value)
    return asked[:ticks]


@settings(deadline=None, max_examples=100)
@given(st.integers(0, 10**6), st.integers(0, ROOM - 2), st.sampled_from([0.0, 0.21, 4.0]),
       st.sampled_from([None, -0.9, -0.004, 0.001, 0.03, 0.4]))
def test_after_hours_a_long_delay_is_as_exact_as_a_short_one(seed, ticks, rate, off):
    """Also where a sensor finds the actuator elsewhere than the model has it, by `off`."""
    asked = [0.9] * 2000 + swings(seed, 600)
    made = history(asked, PRED_RATE=rate)
    made.begin(ticks, 0.0, None)
    measured = None if off is None else max(-1.0, min(1.0, made.position / ONE + off))
    made.begin(ticks, 0.0, None if measured is None else round(measured * ONE))
    position = made.position / ONE
    total = moment = 0.0
    for index, target in enumerate(asked[len(asked) - ticks :]):
        reach = rate * PERIOD_S if rate else 10.0
        way = target - position
        ramp = min(1.0, abs(way) / reach) if rate else 0.0  # share of the tick
        step = max(-reach, min(reach, way))
        mean = position + step * (1.0 - 0.5 * ramp)
        position += step
        total += mean
        moment += (index + 0.5 - 0.5 * ticks) * mean + step * ramp * (0.25 - ramp / 6.0)
    made.advance(0.0, ticks, 0.0)
    slack = rate * PERIOD_S if off is not None else 0.0  # what a path beside the model's may be off by
    assert made.position / ONE == pytest.approx(position, abs=slack + 2e-4)
    assert made.total / ONE == pytest.approx(total, abs=(0.2 * slack + 1e-5) * (1 + ticks))
    assert made.moment / ONE == pytest.approx(moment, abs=(slack + 1e-4) * (1 + ticks))


def test_a_measured_position_is_where_the_model_goes_on_from():
    made = history([0.5] * 30, PRED_RATE=5.0)
    made.begin(4, 0.0, round(-0.1 * ONE))
    made.advance(0.0, 4, 0.0)
    assert made.position / ONE == pytest.approx(0.3, abs=1e-5)  # 0.1 a tick
    made.begin(4, 0.0, None)
    made.advance(0.0, 4, 0.0)
    assert made.position / ONE == pytest.approx(0.5, abs=1e-5)
    made.begin(2, 0.0, 100 * ONE)  # a sensor that has lost its mind
    assert made.position <= 2 * ONE


def test_a_loop_that_was_held_up_held_its_steering():
    steady, held_up = history([0.1] * 10), history([0.1] * 7)
    for _ in range(3):
        steady.note(0.1, 1)
    steady.note(-0.4, 1)
    held_up.note(-0.4, 7)
    for made in (steady, held_up):
        made.begin(5, 0.0, None)
        made.advance(0.0, 5, 0.0)
    assert (steady.total, steady.moment, steady.position) == (held_up.total, held_up.moment, held_up.position)
    held_up.note(0.0, 10**6)  # for hours
    held_up.begin(ROOM - 1, 0.0, None)
    held_up.advance(0.0, ROOM - 1, 0.5)
    assert held_up.total / ONE == pytest.approx(-0.4 * (ROOM - 2))


@pytest.mark.parametrize("ticks", [0, 1, ROOM - 1, ROOM, ROOM + 1, 3 * ROOM])
def test_the_ring_goes_round(ticks):
    made = history([0.25 if tick % 2 else -0.25 for tick in range(ticks)])
    made.begin(0, 0.0, None)
    made.advance(0.0, 0, 0.5)
    assert made.total / ONE == (0.0 if not ticks else -0.125 if ticks % 2 else 0.125)
