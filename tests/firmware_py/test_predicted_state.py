"""The state carried forward: it is the plant's own, whatever happens to samples and clocks."""

import math
from typing import Any

import pytest
from eights import gains, parameters
from firmware_bench import EVERYTHING, STEERING, sample
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from firmware_py.clock import MASK
from firmware_py.control.steering import Steering
from firmware_py.estimation.estimator import Estimator
from firmware_py.prediction.prediction import Prediction
from firmware_py.prediction.steering_history import SteeringHistory
from protocol.parameter_table import load_parameters
from sim_bridge.equipment.actuator import Actuator
from sim_bridge.equipment.actuator_settings import ActuatorSettings
from sim_bridge.plants.turning_rate import TurningRatePlant
from sim_bridge.plants.turning_rate_settings import TurningRateSettings
from sim_bridge.wind.air import Air
from sim_bridge.wind.wind_settings import WindSettings

FINE = 20
AIR = Air(8.0)
angles = st.tuples(st.floats(-1.0, 1.0), st.floats(0.2, 1.1), st.floats(-3.1, 3.1))
kites = st.tuples(st.floats(0.05, 0.4), st.floats(8.0, 20.0), st.floats(40.0, 300.0))  # K, airspeed, line length


class Sky:
    """A kite of the plant with its actuator, and the firmware's prediction of it, tick by tick."""

    def __init__(self, at, kite, delay: float, rate: float = 0.0, loop_hz: float = 50.0, air: Air = AIR, **plant: Any):
        azimuth, elevation, course = at
        turn_k, airspeed, length = kite
        self.period = 1.0 / loop_hz
        self.delay = max(1, round(delay / self.period))
        law = TurningRateSettings(turn_k=turn_k, airspeed_m_s=airspeed, speed_over_length=airspeed / length,
                                  line_length_m=length, **plant)
        self.length = length
        self.actuator = Actuator(ActuatorSettings(rate_limit_per_s=rate, saturation=1.0))
        up = (-math.sin(elevation) * math.cos(azimuth), -math.sin(elevation) * math.sin(azimuth), math.cos(elevation))
        across = (math.sin(azimuth), -math.cos(azimuth), 0.0)
        x, y, z = (math.cos(course) * e1 + math.sin(course) * e2 for e1, e2 in zip(up, across, strict=True))
        position = (math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth),
                    math.sin(elevation))
        self.plant = TurningRatePlant(law, WindSettings(), position, (x, y, z))
        self.air = air
        self.plant.step(1e-9, 0.0, air)
        values = parameters(
            PRED_DELAY=self.delay * self.period, PRED_RATE=rate, PRED_SAT=1.0, TURN_K=turn_k, LOOP_HZ=loop_hz,
            GRAVITY_C=plant.get("gravity_m_s2", 0.0), TURN_OFFSET=plant.get("offset_rad_s", 0.0))
        self.turn_k = turn_k
        self.history = SteeringHistory()
        self.history.load(values)
        self.prediction = Prediction(self.history)
        self.prediction.config.load(values)
        self.kite = Estimator()
        self.kite.config.load(values)
        self.asked: list[float] = []
        self.now = 0

    def tick(self, steering: float) -> None:
        """A tick: `steering` is sent, and what was sent a dead time ago is felt."""
        self.history.note(steering, 1)
        self.asked.append(steering)
        self.now += round(self.period * 1e6)
        self.fly(self.asked[-1 - self.delay] if len(self.asked) > self.delay else 0.0)

    def fly(self, steering: float, share: float = 1.0) -> None:
        """The plant flies on for a `share` of a tick with `steering` felt."""
        self.actuator.command(0.0, steering)
        self.actuator.apply_due(0.0)
        dt = self.period / FINE
        for _ in range(round(FINE * share)):
            self.actuator.advance(0.5 * dt)
            self.plant.step(dt, self.actuator.position, self.air)
            self.actuator.advance(0.5 * dt)

    def see(self) -> None:
        """The firmware gets a perfect sample of the present, at once."""
        truth, kite = self.plant.truth(), self.kite
        x, y, z = truth.position
        kite.frame.set(math.atan2(y, x), math.asin(z))
        kite.course, kite.heading, kite.airspeed = truth.course, truth.heading, truth.airspeed
        kite.distance, kite.speed = self.length, self.length * math.hypot(*truth.velocity)
        kite.steering, kite.valid, kite.sample_time = self.actuator.position, EVERYTHING, self.now
        self.prediction.note_sample(kite, self.now)

    def miss(self) -> tuple[float, float]:
        """(position, course) [rad]: how far from the prediction the plant is when half of the next steering is felt,
        which is taken to be the last one's."""
        self.prediction.update(self.kite, self.now, self.turn_k)
        frame = self.prediction.frame
        for steering in self.asked[len(self.asked) - self.delay :]:
            self.fly(steering)
        self.fly(self.asked[-1], 0.5)
        truth = self.plant.truth()
        off = (a - b for a, b in zip(truth.position, (frame.x, frame.y, frame.z), strict=True))
        return math.hypot(*off), abs(math.remainder(truth.course - self.prediction.course, 2.0 * math.pi))


@settings(deadline=None, max_examples=60)
@given(angles, kites, st.floats(-1.0, 1.0), st.floats(0.02, 0.8), st.sampled_from([10.0, 50.0, 100.0]))
def test_over_the_dead_time_it_is_the_plants_own_flight(at, kite, steering, delay, loop_hz):
    """Known steering, to 1e-6 rad: arcs are exact for it. Steering is known to 2^-21."""
    sky = Sky(at, kite, delay, loop_hz=loop_hz)
    for _ in range(sky.delay + 3):
        sky.tick(steering)
    sky.see()
    position, course = sky.miss()
    turning = delay * kite[0] * kite[1]
    assert position < 1e-6 * max(1.0, turning)
    assert course * sky.prediction.frame.e1z < 1e-6 * max(1.0, turning)  # (meridians converge)


@settings(deadline=None, max_examples=60)
@given(angles, kites, st.lists(st.floats(-1.0, 1.0), min_size=40, max_size=40), st.sampled_from([0.2, 4.0]),
       st.floats(0.05, 0.4), st.booleans())
def test_steering_that_changes_goes_through_the_actuators_limits(at, kite, asked, rate, delay, measured):
    """Any steering, however wild, through a rate limit, from the actuator as measured or as modelled."""
    sky = Sky(at, kite, delay, rate)
    for steering in asked:
        sky.tick(steering)
    sky.see()
    if not measured:
        sky.kite.valid &= ~STEERING
    position, course = sky.miss()
    assert position < 2e-4
    assert course * sky.prediction.frame.e1z < 2e-4


def test_gravity_and_an_offset_turn_it_on_the_way():
    """The V3 kite's numbers, in a turn, half a second on: 2 mrad where gravity and offset make 80."""
    sky = Sky((0.3, 0.6, 1.0), (0.215, 19.0, 290.0), 0.5, 0.2, gravity_m_s2=4.0, offset_rad_s=-0.1)
    for tick in range(60):
        sky.tick(-0.006 * tick)
    sky.see()
    position, course = sky.miss()
    assert position < 2e-4
    assert course < 2e-3


def test_the_wind_turns_past_a_kite_that_turns():
    """In the glide law's wind course and heading differ, by another angle at the end of the dead time."""
    sky = Sky((0.3, 0.6, 1.0), (0.215, 19.0, 290.0), 0.5, 0.2, speed_law="glide", glide_ratio=2.85)
    for _ in range(150):
        sky.tick(-0.3)
        sky.see()
    before = math.remainder(sky.kite.course - sky.kite.heading, 2.0 * math.pi)
    position, course = sky.miss()
    truth = sky.plant.truth()
    after = math.remainder(truth.course - truth.heading, 2.0 * math.pi)
    assert abs(after - before) > 0.07
    assert position < 2e-3
    assert course < 0.03


@settings(deadline=None, max_examples=60)
@given(st.tuples(st.floats(-0.6, 0.6), st.floats(0.4, 0.9), st.floats(-3.1, 3.1)), st.floats(-0.5, 0.5))
def test_the_first_sample_says_the_whole_wind_and_the_next_ones_that_it_is_the_same(at, direction):
    """In the glide law's wind from any direction, wherever the kite is: 8 m/s, then through a turn of four seconds,
    where the smoothed airspeed lags."""
    sky = Sky(at, (0.215, 19.0, 290.0), 0.5, air=Air(8.0, direction), speed_law="glide", glide_ratio=2.85)
    drift = sky.prediction._drift
    for tick in range(200):
        sky.see()
        assume(sky.kite.course != sky.kite.heading)  # else there may be no wind across the tether
        sky.kite.interval = sky.period
        wind = 290.0 * drift._wind_x, 290.0 * drift._wind_y
        assert wind == pytest.approx((8.0 * math.cos(direction), 8.0 * math.sin(direction)), abs=0.15 if tick else 1e-9)
        sky.tick(0.3)


def test_a_lost_sample_is_bridged_by_a_longer_way():
    """Four ticks without a sample, in a turn: the prediction from the old one is the one from a new one."""
    with_all, without = (Sky((0.3, 0.7, 1.0), (0.3, 18.0, 40.0), 0.2, 4.0) for _ in range(2))
    for tick in range(60):
        for sky in (with_all, without):
            if tick < 56 or sky is with_all:
                sky.see()
            sky.prediction.update(sky.kite, sky.now, sky.turn_k)
            sky.tick(0.5 * math.sin(0.1 * tick))
    ours, theirs = without.prediction, with_all.prediction
    assert ours.horizon_us - theirs.horizon_us == 4 * 20000
    assert ours.course == pytest.approx(theirs.course, abs=1e-4)
    assert (ours.frame.x, ours.frame.y, ours.frame.z) == pytest.approx(
        (theirs.frame.x, theirs.frame.y, theirs.frame.z), abs=2e-5)


@pytest.mark.parametrize("late_us", [0, 8000, 16000])
def test_a_tick_that_begins_late_is_one_of_the_beat_whose_steering_is_held_for_less(late_us):
    """The steering before it acts until it ends, and its own for the rest of the period: half of that is the end.

    The sample is no older for it: the usual age stays that of the beat.
    """
    sky = Sky((0.3, 0.7, 1.0), (0.3, 18.0, 40.0), 0.2, 4.0)
    for tick in range(60):
        sky.tick(0.5 * math.sin(0.1 * tick))
        sky.see()
    sky.prediction.update(sky.kite, sky.now, sky.turn_k, late_us)
    assert sky.prediction.horizon_us == 200000
    frame = sky.prediction.frame
    for steering in sky.asked[len(sky.asked) - sky.delay :]:
        sky.fly(steering)
    sky.fly(sky.asked[-1], 0.5 + 0.5 * late_us / 20000)
    truth = sky.plant.truth()
    assert (frame.x, frame.y, frame.z) == pytest.approx(truth.position, abs=5e-5)
    assert sky.prediction.course == pytest.approx(truth.course, abs=2e-4)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, MASK), st.integers(0, 100000))
def test_clocks_need_not_agree(offset, usual_us):
    """Whatever the sender's clock says: a sample of the usual age is one dead time away, a late one later."""
    sky = Sky((0.3, 0.7, 1.0), (0.3, 18.0, 40.0), 0.2)
    prediction, kite = sky.prediction, sky.kite
    kite.distance = 40.0
    now = 0
    for tick in range(300):
        jitter = 8000 if tick % 2 else -8000
        now = (tick * 20000 + offset) & MASK
        kite.sample_time = (tick * 20000 - usual_us - jitter) & MASK
        kite.interval = 0.02
        prediction.note_sample(kite, now)
        prediction.update(kite, now, sky.turn_k)
    assert prediction.horizon_us == pytest.approx(200000 + 8000, abs=300)
    prediction.update(kite, (now + 60000) & MASK, sky.turn_k)
    assert prediction.horizon_us == pytest.approx(268000, abs=300)
    kite.sample_time = (kite.sample_time + 300_000_000) & MASK  # somebody sets the clock
    prediction.note_sample(kite, now)
    prediction.update(kite, now, sky.turn_k)
    assert prediction.horizon_us == 200000


extreme = st.floats(-1e6, 1e6, width=32)
LIMITS = {name: (entry.least, entry.greatest) for name, entry in load_parameters().items()}
AT_LIMITS = ("PRED_DELAY", "PRED_RATE", "PRED_SAT", "TURN_K", "TURN_OFFSET", "GRAVITY_C", "AIRSPEED_MIN", "LOOP_HZ",
             "INNER_P", "STEER_MAX", "COURSE_WINDOW", "STALE_TIME")


@settings(deadline=None, max_examples=200)
@given(st.lists(st.booleans(), min_size=len(AT_LIMITS), max_size=len(AT_LIMITS)), extreme, extreme,
       st.floats(0.0, 1e6), st.floats(1e-3, 1e6), st.floats(0.0, 1e6), st.floats(-1.57, 1.57), extreme,
       st.integers(-2_000_000, 2_000_000))
@example([True] * len(AT_LIMITS), 1e6, -1e6, 1e6, 1e-3, 1e6, 1.5707, 1e6, 2_000_000)
@example([False] * len(AT_LIMITS), 1e6, -1e6, 1e6, 1e-3, 1e6, -1.5707, 1e6, 2_000_000)
def test_nothing_absurd_comes_of_absurd_samples_and_parameters(
        high, course, heading, airspeed, distance, speed, elevation, steering, late_us):
    """Every parameter at one end or the other of its range: numbers, unit vectors, steering within limits."""
    extremes = {name: LIMITS[name][up] for name, up in zip(AT_LIMITS, high, strict=True)}
    values, flown = parameters(**extremes), gains(**extremes)
    history = SteeringHistory()
    prediction, loop, kite = Prediction(history), Steering(), Estimator()
    for config in (history, prediction.config, loop.config, kite.config):
        config.load(values)
    kite.frame.set(0.3, elevation)
    kite.course, kite.heading, kite.airspeed, kite.distance, kite.speed = course, heading, airspeed, distance, speed
    kite.steering, kite.valid, kite.interval = steering, EVERYTHING, 0.02
    for tick in range(4):
        kite.sample_time = tick * 20000
        prediction.note_sample(kite, tick * 20000)
        prediction.update(kite, tick * 20000 + late_us, flown.turn_k)
        loop.follow(1.0, 0.5, prediction, flown, 0.02)
        history.note(loop.asked, 1)
        frame = prediction.frame
        assert frame.x**2 + frame.y**2 + frame.z**2 == pytest.approx(1.0, abs=1e-6)
        assert frame.e2x**2 + frame.e2y**2 == pytest.approx(1.0, abs=1e-9)
        assert -math.pi < prediction.course <= math.pi
        assert math.isfinite(prediction.speed) and 0.5 <= prediction.turning_ratio <= 2.0
        assert abs(loop.asked) <= values[list(LIMITS).index("STEER_MAX")]


def test_an_actuator_still_under_way_is_reckoned_with():
    """A slow actuator that turns the kite must stop before the target, by the way it still makes: d^2 / (2 slew)."""
    loop = Steering()
    loop.config.load(parameters(STEER_MAX=1.0))
    flown = gains(INNER_P=2.0, TURN_K=0.25)
    prediction = Prediction(SteeringHistory())
    prediction.airspeed, prediction.course, prediction.steered_turning = 20.0, 0.0, 1.0
    loop.follow(0.4, 0.0, prediction, flown, 0.02)
    assert loop.asked == pytest.approx(2.0 * 0.4 / 5.0)
    prediction.turning_slew = 1.25  # 1 rad/s is gone in 0.8 s and 0.4 rad
    loop.follow(0.4, 0.0, prediction, flown, 0.02)
    assert loop.asked == pytest.approx(0.0, abs=1e-12)
    assert loop.error == 0.4
    prediction.steered_turning = -1.0
    loop.follow(0.4, 0.0, prediction, flown, 0.02)
    assert loop.asked == pytest.approx(2.0 * 0.8 / 5.0)


def test_the_speed_is_the_arcs_not_the_chords():
    """A small circle flown at 18 m/s on 40 m, turning by 2.5 rad/s: the chord of a quarter of a second is 2 % short."""
    sky = Sky((0.3, 0.7, 1.0), (0.25, 18.0, 40.0), 0.02)
    kite = Estimator()
    kite.config.load(parameters())
    for tick in range(100):
        sky.tick(0.555)
        truth = sky.plant.truth()
        x, y, z = truth.position
        now = tick * 20000
        taken = sample(now, math.atan2(y, x), math.asin(z), 40.0, truth.course, truth.heading, 18.0)
        kite.wait(20000)
        assert kite.take(taken, 0.0, sky.turn_k)
    assert kite.speed < 0.985 * 18.0
    assert kite.sphere_speed() == pytest.approx(0.45, rel=3e-3)
