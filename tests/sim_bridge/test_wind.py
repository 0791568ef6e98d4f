"""The wind: profiles, gusts against their spectra, what is planned for it, files, and a flight through a lull."""

import math

import numpy as np
import pytest
from scipy.signal import welch

from sim_bridge.cli.main import main
from sim_bridge.errors import ScenarioError
from sim_bridge.flight.flight import Flight
from sim_bridge.flight.truth_columns import COLUMNS
from sim_bridge.runtimes.inproc import InprocRuntime
from sim_bridge.scenario.scenario import load_scenario
from sim_bridge.wind.air import Air
from sim_bridge.wind.gust_scales import dryden_parts, gust_scales
from sim_bridge.wind.profile import EXPLOG, EXPONENTIAL, LOGARITHMIC, air_density, profile_factor, wind_at
from sim_bridge.wind.wind import MeanWind, Wind
from sim_bridge.wind.wind_settings import WindSettings

FOOT = 0.3048


def scenario_with(scenario, **wind):
    for key, value in wind.items():
        scenario.set(f"wind.{key}", value, "test")
    return scenario


def airs(settings, count, period_s=0.02, seed=1, line_m=100.0):
    """The wind at t = 0, period_s, 2 period_s, ... as fields of Air, a row each; the eight at 40 deg."""
    wind, rows = Wind(settings, period_s, seed, line_m * math.sin(math.radians(40.0))), []
    for _ in range(count):
        air = wind.air
        rows.append((air.speed_m_s, air.direction_rad, air.along, air.across, air.vertical))
        wind.advance()
    return np.array(rows)


def test_profiles_and_density_have_the_references_values():
    seventh = 1.0 / 7.0
    assert profile_factor(EXPONENTIAL, seventh, 10.0) == pytest.approx(1.0757037, abs=5e-8)
    assert profile_factor(EXPONENTIAL, seventh, 100.0) == pytest.approx(1.494685, abs=5e-7)
    logarithmic = math.log(100.0 / 2e-4) / math.log(6.0 / 2e-4)
    assert profile_factor(LOGARITHMIC, seventh, 100.0) == pytest.approx(logarithmic, rel=1e-12)
    assert profile_factor(EXPLOG, seventh, 100.0) == pytest.approx(2 * logarithmic - 1.494685, abs=5e-7)
    for law in (EXPONENTIAL, LOGARITHMIC, EXPLOG):
        assert profile_factor(law, seventh, 6.0) == profile_factor(law, seventh, -3.0) == 1.0
    assert air_density(100.0) == pytest.approx(1.210756, abs=5e-7)


def test_a_gust_across_goes_to_the_left_of_the_wind_and_one_upwards_goes_up():
    air = Air(10.0, math.radians(90.0), 0.1, 0.2, 0.3)
    assert wind_at(air, EXPONENTIAL, 0.0, 50.0) == pytest.approx((-2.0, 11.0, 3.0))


def test_lengths_and_intensities_are_those_of_the_military_specification():
    for kind, high_ft in (("dryden", 1750.0), ("von-karman", 2500.0)):
        low = gust_scales(kind, 200.0 * FOOT)
        assert low.horizontal / FOOT == pytest.approx(200.0 / 0.3416**1.2)
        assert low.vertical / FOOT == pytest.approx(200.0)
        assert low.vertical_share == pytest.approx(0.3416**0.4)
        assert gust_scales(kind, 1500.0 * FOOT) == pytest.approx(((1000.0 + high_ft) / 2 * FOOT,) * 2 + (1.0,))
        assert gust_scales(kind, 3000.0 * FOOT) == pytest.approx((high_ft * FOOT,) * 2 + (1.0,))
        below, above = (gust_scales(kind, h * FOOT) for h in (1000.0 - 1e-6, 1000.0 + 1e-6))
        assert below == pytest.approx(above, rel=1e-6)


def spectra(kind):
    """Of MIL-F-8785C, variance 1: longitudinal and transverse, functions of L Omega, per L Omega from 0 on."""
    if kind == "dryden":
        return (lambda x: 2 / np.pi / (1 + x**2)), (lambda x: (1 + 3 * x**2) / (1 + x**2) ** 2 / np.pi)
    a = 1.339
    return ((lambda x: 2 / np.pi * (1 + (a * x) ** 2) ** (-5 / 6)),
            (lambda x: (1 + 8 / 3 * (a * x) ** 2) / (1 + (a * x) ** 2) ** (11 / 6) / np.pi))


def test_von_karmans_spectra_are_sums_of_drydens():
    x = np.logspace(-4, math.log10(6000 / 1.339), 300)
    for wanted, part in zip(spectra("von-karman"), spectra("dryden"), strict=True):
        got = sum(share * length * part(length * x) for share, length in dryden_parts("von-karman"))
        assert np.abs(got / wanted(x) - 1).max() < 0.005
    assert math.fsum(share for share, _ in dryden_parts("von-karman")) == pytest.approx(1.0)


@pytest.mark.parametrize("period_s", [0.02, 0.2])
@pytest.mark.parametrize("kind", ["dryden", "von-karman"])
def test_gusts_have_the_spectra_and_variances_of_their_kind_at_any_tick_rate(kind, period_s):
    """Welch's periodogram up to the Nyquist frequency, against the analytic spectrum with what is aliased into it.

    All bounds are 4.5 standard deviations of the estimate. A line of 60 m makes the eight's height 126.5 ft, which
    gives lengths of 177 m and 38.6 m: time constants of 1.8 s and 0.4 s.
    """
    count, block, speed = 2**16, 2**11, 100.0
    settings = WindSettings(gusts=kind, turbulence_intensity=0.2, convection_m_s=speed)
    gusts = airs(settings, count, period_s, line_m=60.0)[:, 2:]
    h = 60.0 * math.sin(math.radians(40.0)) / FOOT
    base = 0.177 + 0.000823 * h
    longitudinal, transverse = spectra(kind)
    deviations = (0.2, 0.2, 0.2 * base**0.4)
    lengths = (h / base**1.2 * FOOT, h / base**1.2 * FOOT, h * FOOT)
    for gust, spectrum, deviation, length in zip(
            gusts.T, (longitudinal, transverse, transverse), deviations, lengths, strict=True):
        scale = 2 * np.pi * length / speed
        frequency, power = welch(gust, 1 / period_s, nperseg=block)
        images = np.abs(frequency[:, None] + np.arange(-2000, 2001) / period_s)
        wanted = deviation**2 * scale * spectrum(scale * images).sum(axis=1)
        blocks = 0.9 * (2 * count / block - 1)  # they overlap by half
        for low in 2 ** np.arange(3, 10):  # octaves, from where Hann's window no longer smears the slope
            ratio = (power / wanted)[low : 2 * low].mean()
            assert ratio == pytest.approx(1.0, abs=4.5 / math.sqrt(blocks * low))
        correlation_s = length / speed  # integral over all lags of the squared correlation, about
        assert gust.var() == pytest.approx(
            deviation**2, rel=4.5 * math.sqrt(2 * max(correlation_s, period_s) / (count * period_s)))
    independent = max(lengths[0] / speed, period_s) / (count * period_s)
    assert np.abs(np.corrcoef(gusts.T) - np.eye(3)).max() < 4.5 * math.sqrt(independent)


@pytest.mark.parametrize("kind", ["first-order", "dryden", "von-karman"])
def test_gusts_repeat_with_their_seed_and_scale_with_their_intensity(kind):
    def gusts(seed, intensity):
        return airs(WindSettings(gusts=kind, turbulence_intensity=intensity), 50, seed=seed)[:, 2:]

    assert (gusts(3, 0.1) == gusts(3, 0.1)).all()
    assert np.abs(gusts(3, 0.1) - gusts(4, 0.1)).max() > 0.01
    assert gusts(3, 0.2) == pytest.approx(2 * gusts(3, 0.1))
    assert not gusts(3, 0.0).any()
    across_and_up = np.abs(gusts(3, 0.1)[:, 1:]).max(axis=0)
    assert (across_and_up == 0.0).all() if kind == "first-order" else (across_and_up > 0.001).all()


def test_given_lengths_make_gusts_isotropic_and_given_convection_speeds_them_up():
    """Over one period, a gust along changes by sqrt(2 (1 - exp(-V period / L))) of its deviation."""
    for length, speed in ((100.0, None), (100.0, 40.0), (25.0, 40.0)):
        settings = WindSettings(gusts="dryden", turbulence_intensity=0.1, turbulence_length_m=length,
                                convection_m_s=speed)
        change = np.diff(airs(settings, 5000), axis=0).std(axis=0)
        expected = 0.1 * math.sqrt(2 * (1 - math.exp(-(speed or 8.0) * 0.02 / length)))
        assert change[2] == pytest.approx(expected, rel=0.05)
        assert change[3] == pytest.approx(change[4], rel=0.05)


def test_a_step_is_sharp_and_stops_at_nothing():
    speed = airs(WindSettings(step_s=1.0, step_m_s=-3.0), 100)[:, 0]
    assert (speed[:50] == 8.0).all() and (speed[50:] == 5.0).all()
    assert (airs(WindSettings(step_s=1.0, step_m_s=-30.0), 100)[50:, 0] == 0.0).all()


@pytest.mark.parametrize(("ramp", "left"), [(3.0, 0.0), (2.0, 0.25), (0.0, 0.0)])
def test_a_lull_comes_smoothly_lasts_and_goes(ramp, left):
    speed = airs(WindSettings(lull_start_s=2.0, lull_ramp_s=ramp, lull_length_s=4.0, lull_to=left), 1000)[:, 0]
    time = np.arange(1000) * 0.02
    lull = (time >= 2.0 + ramp) & (time < 6.0 + ramp - 1e-9)
    assert speed[lull] == pytest.approx(8.0 * left, abs=1e-12)
    assert speed[(time < 2.0) | (time >= 6.0 + 2 * ramp)] == pytest.approx(8.0)
    if ramp:
        assert np.abs(np.diff(speed)).max() / 0.02 == pytest.approx(math.pi / 2 * 8.0 * (1 - left) / ramp, rel=1e-3)
        assert np.abs(np.diff(speed, 2)).max() < 0.01  # no corner: the slope itself is up to 0.08 a tick


@pytest.mark.parametrize("by", [60.0, -200.0])
def test_the_wind_turns_by_what_was_asked_no_faster_than_was_asked(by):
    direction = np.degrees(airs(WindSettings(turn_start_s=1.0, turn_by_deg=by, turn_rate_deg_s=20.0), 1000)[:, 1])
    assert (direction[:51] == 0.0).all()
    assert direction[-1] == pytest.approx(by)
    rates = np.diff(direction) / 0.02 * math.copysign(1.0, by)
    assert rates.min() >= -1e-9 and rates.max() == pytest.approx(20.0, rel=1e-3)


def write(folder, text):
    path = folder / "wind.csv"
    path.write_text(text, "utf-8")
    return str(path)


def test_a_file_is_linear_in_between_turns_the_short_way_and_holds_its_ends(tmp_path):
    path = write(tmp_path, "# a mast\ndirection_deg, time_s, speed_m_s, vertical_m_s\n350,1,6,0\n\n10,3,8,0.8\n")
    held = airs(WindSettings(file=path), 9, 0.5)
    assert held[:, 0] == pytest.approx([6, 6, 6, 6.5, 7, 7.5, 8, 8, 8])
    assert np.degrees(held[:, 1]) == pytest.approx([350, 350, 350, 355, 360, 365, 370, 370, 370])
    assert held[:, 4] == pytest.approx([0, 0, 0, 0.2 / 6.5, 0.4 / 7, 0.6 / 7.5, 0.1, 0.1, 0.1])
    again = airs(WindSettings(file=path, file_repeat=True), 9, 0.5)
    assert again[:, 0] == pytest.approx([6, 6, 6, 6.5, 7, 7.5, 8, 6.5, 7])


def test_what_is_planned_and_gusts_come_on_top_of_a_file(tmp_path):
    path = write(tmp_path, "time_s,speed_m_s,vertical_m_s\n0,10,1\n")
    both = airs(WindSettings(file=path, step_s=0.5, step_m_s=2.0, turn_by_deg=30.0, turn_rate_deg_s=360.0,
                             gusts="dryden", turbulence_intensity=0.1), 100)
    assert both[-1, 0] == 12.0 and math.degrees(both[-1, 1]) == pytest.approx(30.0)
    # carried past at the file's mean speed, so these are the gusts of a wind of 10 m/s
    gusts = airs(WindSettings(speed_m_s=10.0, gusts="dryden", turbulence_intensity=0.1), 100)
    assert both[:, 2:4] == pytest.approx(gusts[:, 2:4])
    assert both[:, 4] == pytest.approx(0.1 + gusts[:, 4])


@pytest.mark.parametrize(("text", "said"), [
    ("", "no line of numbers"), ("time_s,speed_m_s\n", "no line of numbers"),
    ("time_s,speed\n0,1\n", ":1: no column speed; columns are time_s, speed_m_s, direction_deg, vertical_m_s"),
    ("time_s\n0\n", ":1: column speed_m_s is missing"),
    ("time_s,speed_m_s,time_s\n0,1,0\n", ":1: column time_s appears twice"),
    ("time_s,speed_m_s\n0,8\n1\n", ":3: 1 values for 2 columns"),
    ("time_s,speed_m_s\n0,eight\n", ":2: speed_m_s 'eight' is not a number"),
    ("time_s,speed_m_s\n0,nan\n", ":2: speed_m_s nan is not finite"),
    ("#\n\ntime_s,speed_m_s\n0,-1\n", ":4: speed_m_s = -1 is outside 0 to 100"),
    ("time_s,speed_m_s\n1,8\n1,9\n", ":3: time_s 1 should come after 1"),
    ("time_s,speed_m_s,vertical_m_s\n1,0,0.5\n", ":2: vertical_m_s = 0.5 is more than the speed_m_s 0"),
    ("time_s;speed_m_s\n1;8\n", ":1: no column time_s;speed_m_s"),
])
def test_a_bad_file_is_said_in_one_line_with_the_line_in_it(tmp_path, text, said):
    path = write(tmp_path, text)
    with pytest.raises(ScenarioError) as error:
        MeanWind(WindSettings(file=path))
    assert path in str(error.value) and said in str(error.value) and "\n" not in str(error.value)


def test_a_file_that_cannot_be_used_ends_the_command_with_one_line(tmp_path, capsys):
    one_line = write(tmp_path, "time_s,speed_m_s\n0,8\n")
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"\xff\xfe\x00")
    for settings, said in (
        ([f"wind.file={tmp_path / 'none.csv'}"], "No such file"), ([f"wind.file={binary}"], "not UTF-8 text"),
        ([f"wind.file={one_line}", "wind.file_repeat=true"], "two lines of numbers"),
        (["wind.gusts=mann"], "is one of first-order, dryden, von-karman"),
    ):
        assert main(["run", "small-kite", *(word for s in settings for word in ("--set", s))]) == 2
        error = capsys.readouterr().err
        assert said in error and error.count("\n") == 1


def test_gusts_of_a_flight_are_those_at_the_height_of_its_eight():
    scenario = scenario_with(load_scenario("small-kite"), gusts="dryden", turbulence_intensity=0.1, profile="log")
    flight = Flight(scenario, InprocRuntime())
    flight.fly(1.0)
    line_m, elevation = scenario.plant.line_length_m, math.radians(scenario.parameter("EIGHT_ELEVATION"))
    wind, expected = Wind(scenario.wind, 0.02, scenario.run.seed, line_m * math.sin(elevation)), []
    for _ in flight.rows:
        expected.append(wind.air.speed_m_s * wind.air.gust)
        wind.advance()
    assert np.array(flight.rows)[:, COLUMNS.index("wind_m_s")] == pytest.approx(expected)
    assert np.std(expected) > 0.01


@pytest.mark.parametrize("name", ["small-kite", "v3-flight"])
def test_a_kite_stands_still_in_a_lull_to_nothing_and_flies_its_eight_again_after_it(name):
    """Settle until 30 s, no wind from 32 to 40 s, wind again from 42 s."""
    scenario = scenario_with(load_scenario(name), lull_start_s=30.0, lull_ramp_s=2.0, lull_length_s=8.0,
                             turbulence_intensity=0.0)
    runtime = InprocRuntime(False)
    flight = Flight(scenario, runtime)
    runtime.start()
    flight.fly(90.0)
    runtime.stop()
    rows = np.array(flight.rows)
    time, airspeed, cross_track = rows[:, 0], rows[:, 5], np.abs(rows[:, 9])
    assert np.isfinite(rows).all()
    still = (time > 32.1) & (time < 39.9)
    assert np.ptp(rows[still, 1:5], axis=0) == pytest.approx(0.0, abs=1e-12)  # position, course and heading
    assert airspeed[still] == pytest.approx(0.0)
    before, after = ((time > t) & (time < t + 20.0) for t in (10.0, 70.0))
    assert cross_track[after].max() < 1.5 * cross_track[before].max()
