"""The state carried forward, the steering's history and what adapts, on the interpreter at hand."""

from math import cos, pi, sin, sqrt

from firmware_py import generated_enums as enums
from firmware_py.control.gains import Gains
from firmware_py.estimation.estimator import Estimator
from firmware_py.estimation.turn_k_estimate import TurnKEstimate
from firmware_py.parameters import generated_parameters as table
from firmware_py.parameters.values import Parameters
from firmware_py.prediction.prediction import Prediction
from firmware_py.prediction.steering_history import ONE, SteeringHistory

_VALID = 0xFF
_PERIOD_US = 20000
_TURN_K = 0.25


def values_with(*changes):
    """The parameters' values, at their defaults but for pairs of index and value."""
    values = list(Parameters().values)
    for index, value in changes:
        values[index] = value
    return values


def near(value, wanted, tolerance=1e-5):
    return abs(value - wanted) <= tolerance


def predictor(*changes):
    """(prediction, its history, a kite at azimuth 0 and elevation 0 that flies up at 20 m/s on 100 m)."""
    values = values_with((table.PRED_DELAY, 0.5), *changes)
    history = SteeringHistory()
    prediction = Prediction(history)
    history.load(values)
    prediction.config.load(values)
    kite = Estimator()
    kite.config.load(values)
    kite.frame.set(0.0, 0.0)
    kite.course = kite.heading = 0.0
    kite.airspeed = kite.speed = 20.0
    kite.distance = 100.0
    kite.valid = _VALID
    prediction.note_sample(kite, 0)
    return prediction, history, kite


def test_straight_flight_is_a_great_circle():
    prediction, _, kite = predictor()
    prediction.update(kite, 0, _TURN_K)
    way = 0.2 * 0.51  # the dead time and half a tick
    assert near(prediction.frame.x, cos(way)) and near(prediction.frame.z, sin(way)) and near(prediction.frame.y, 0.0)
    assert near(prediction.course, 0.0) and prediction.horizon_us == 500000


def test_steady_steering_flies_a_small_circle_of_the_right_size():
    """Turning by r at v: the axis is tilted by atan(v / r) from the kite, and the circle is gone round in 2 pi / w."""
    prediction, history, kite = predictor((table.PRED_DELAY, 0.99))
    for _ in range(60):
        history.note(0.5, 1)
    kite.steering = 0.5
    turning, speed = 0.25 * 20.0 * 0.5, 0.2
    rate = sqrt(turning * turning + speed * speed)
    prediction.update(kite, 0, _TURN_K)
    angle = rate * 1.0
    axis_x, axis_y = turning / rate, -speed / rate  # Omega = r gamma + v b, and b is -y here
    along = (1.0 - cos(angle)) * axis_x
    assert near(prediction.frame.x, cos(angle) + along * axis_x)
    assert near(prediction.frame.y, along * axis_y)
    assert near(prediction.frame.z, -sin(angle) * axis_y)
    frame = prediction.frame
    assert near(frame.x * frame.x + frame.y * frame.y + frame.z * frame.z, 1.0)


def test_an_old_sample_is_a_longer_way():
    prediction, _, kite = predictor()
    prediction.update(kite, 3 * _PERIOD_US, _TURN_K)
    assert prediction.horizon_us == 560000 and near(prediction.frame.z, sin(0.2 * 0.57))


def test_the_actuator_goes_no_faster_and_no_further_than_it_can():
    history = SteeringHistory()
    history.load(values_with((table.PRED_RATE, 2.5), (table.PRED_SAT, 0.25)))
    for _ in range(20):
        history.note(1.0, 1)
    history.begin(20, 0.0, 0)
    history.advance(0.0, 4, 0.0)
    assert near(history.position / ONE, 0.2) and near(history.total / ONE, 0.4)  # 0.05 a tick: 0, 0.05, ... 0.2
    assert near(history.moment / ONE, 0.2 * 16.0 / 12.0)  # of a ramp: slope n^3 / 12
    history.advance(0.0, 16, 0.5)
    assert near(history.position / ONE, 0.25)


def test_the_largest_sums_come_out_right():
    """Full steering over 0.6 s at 50 Hz."""
    history = SteeringHistory()
    history.load(values_with((table.PRED_RATE, 4.0)))
    for _ in range(80):
        history.note(-1.0, 1)
    history.begin(30, 0.5, None)
    history.advance(0.5, 29, 0.5)
    assert near(history.total / ONE, -30.0) and near(history.moment / ONE, 0.0, 1e-3)


def test_the_turning_rate_constant_is_found():
    estimate = TurnKEstimate()
    estimate.load(values_with((table.TURN_K, 0.25)))
    kite = Estimator()
    kite.valid = enums.KITE_VALID_HEADING
    kite.airspeed = 20.0
    kite.interval = 0.02
    angle = 0.0
    for tick in range(1500):
        steering = 0.3 * sin(0.032 * tick)
        estimate.take(kite, steering)
        angle += 0.375 * 20.0 * 0.5 * (steering + 0.3 * sin(0.032 * (tick + 1))) * 0.02
        kite.heading = (angle + pi) % (2.0 * pi) - pi
    assert near(estimate.value, 0.375, 0.004)


def test_gains_follow_airspeed_and_length():
    gains = Gains()
    scheduled = values_with((table.GAIN_TAU, 0.24), (table.GAIN_P_TAU, 0.375), (table.GAIN_L_TAU, 0.25))
    gains.load(scheduled, TurnKEstimate())
    kite = Estimator()
    kite.airspeed = 20.0
    kite.distance = 200.0
    gains.update(kite, TurnKEstimate())
    assert near(gains.gain_p, 1.5) and near(gains.gain_l, 10.0, 1e-4)
