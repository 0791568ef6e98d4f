"""kite-sitl identify: what a simulated kite was made of is found again in its log, and real flights are read."""

import json
from pathlib import Path

import pytest

from kite_analysis.flights.tlog import TlogWriter, read_tlog
from protocol import dialect
from sim_bridge.cli.main import main

FLIGHT = Path(__file__).parent.parent / "data" / "flight" / "20191008_0010.csv.gz"
KEYS = {
    "source", "angle", "transport", "steering", "k_rad_per_m", "k_rad_per_m_std", "gravity_m_s2", "gravity_m_s2_std",
    "offset_rad_s", "offset_rad_s_std", "lag_s", "lag_s_std", "r2", "seconds", "dead_time_s", "dead_time_s_std",
    "rate_limit_per_s", "rate_limit_per_s_std", "saturation", "saturation_std", "steering_reached", "actuator_r2",
    "actuator_missing",
}


def fly(folder: Path, *arguments: str) -> Path:
    assert main(["run", "v3-flight-paper", "--json", "--log", str(folder), *arguments]) == 0
    return folder


def identified(capsys, *arguments: str) -> dict:
    capsys.readouterr()
    assert main(["identify", "--json", *arguments]) == 0
    out, err = capsys.readouterr()
    assert not err
    return json.loads(out)


def refused(capsys, *arguments: str) -> str:
    capsys.readouterr()
    assert main(["identify", *arguments]) == 2
    out, err = capsys.readouterr()
    assert not out and err.count("\n") == 1 and err.startswith("kite-sitl: ")
    return err


@pytest.fixture(scope="module")
def pushed(tmp_path_factory) -> Path:
    """A flight in which the actuator comes to its limits: a high gain, and no limit in the firmware."""
    return fly(tmp_path_factory.mktemp("runs") / "pushed", "--runtime", "cpython", "--duration", "80", "--param",
               "INNER_P=1.6", "--param", "STEER_MAX=0.6", "--set", "link.control.delay_s=0.06",
               "--set", "plant.offset_rad_s=0.1")


def test_a_simulated_kite_gives_back_what_it_was_made_of(capsys, pushed):
    found = identified(capsys, str(pushed))
    assert set(found) == KEYS
    assert found["k_rad_per_m"] == pytest.approx(0.2165, rel=1e-3)
    assert found["gravity_m_s2"] == pytest.approx(3.0, rel=5e-3)
    assert found["offset_rad_s"] == pytest.approx(0.1, abs=1e-3)
    assert found["r2"] > 0.9998 and abs(found["lag_s"]) < 0.005
    # 0.48 s of the actuator and the up-link's share of the delay: 0.06 s less 0.02 s, a period, on the way down.
    assert found["dead_time_s"] == pytest.approx(0.52, abs=0.005)
    assert found["rate_limit_per_s"] == pytest.approx(0.21, rel=2e-3)
    assert found["saturation"] == pytest.approx(0.4, rel=2e-3)


def test_the_tlog_of_a_flight_says_the_same_as_its_truth(capsys, pushed):
    found = identified(capsys, str(pushed / "control.tlog"), "--from", "5")
    assert found["k_rad_per_m"] == pytest.approx(0.2165, rel=2e-3)
    assert found["gravity_m_s2"] == pytest.approx(3.0, rel=0.01)
    assert found["dead_time_s"] == pytest.approx(0.52, abs=0.02)
    assert found["rate_limit_per_s"] == pytest.approx(0.21, rel=0.02)
    assert found["saturation"] == pytest.approx(0.4, rel=0.02)
    assert "no two KITE_STATE" in refused(capsys, str(pushed / "ground.tlog"))


def test_telemetry_of_ten_messages_a_second_is_enough(capsys, pushed, tmp_path):
    """Every fifth KITE_STATE, and every ninth of these lost."""
    states = [(stamp, frame) for stamp, frame in read_tlog(pushed / "control.tlog")
              if int.from_bytes(frame[7:10], "little") == dialect.MAVLINK_MSG_ID_KITE_STATE]
    with TlogWriter(tmp_path / "ground.tlog") as tlog:
        for number, (stamp, frame) in enumerate(states[::5]):
            if number % 9:
                tlog.write(stamp, frame)
    found = identified(capsys, str(tmp_path / "ground.tlog"), "--from", "5")
    assert found["k_rad_per_m"] == pytest.approx(0.2165, rel=0.01)
    assert found["dead_time_s"] == pytest.approx(0.52, abs=0.03)
    assert found["dead_time_s_std"] > 0.02
    assert found["rate_limit_per_s"] == pytest.approx(0.21, rel=0.02)


def test_a_plant_that_does_not_turn_its_meridians_is_taken_as_it_is(capsys, tmp_path):
    """Its own scenario says so; and limits that were never reached are not given. No wind blows it sideways here:
    what the plant leaves out is meridian convergence by its flight along its nose."""
    folder = fly(tmp_path / "held", "--duration", "60", "--set", "plant.transport=false",
                 "--set", "actuator.rate_limit_per_s=0", "--set", "plant.speed_law=constant",
                 "--set", "plant.airspeed_m_s=19", "--set", "plant.speed_over_length=0.065")
    found = identified(capsys, str(folder))
    assert found["transport"] is False
    assert found["k_rad_per_m"] == pytest.approx(0.2165, rel=2e-3)
    assert found["gravity_m_s2"] == pytest.approx(3.0, rel=5e-3)
    assert found["rate_limit_per_s"] is None and found["saturation"] is None
    assert found["dead_time_s"] == pytest.approx(0.48, abs=0.02)
    with_meridians = identified(capsys, str(folder / "truth.csv"))
    assert with_meridians["transport"] is True and with_meridians["r2"] < found["r2"]


def test_a_real_flight_for_a_person(capsys, tmp_path):
    plot = tmp_path / "plots" / "flight.png"
    assert main(["identify", str(FLIGHT), "--plot", str(plot)]) == 0
    out, _ = capsys.readouterr()
    assert plot.stat().st_size > 50_000
    for said in ("K ", "+-", "rad/m", "dead time", "not reached: 0.350", "CC-BY 4.0", str(plot)):
        assert said in out, said
    assert len(out.splitlines()) < 16


def test_the_options_choose_what_is_used(capsys):
    whole = identified(capsys, str(FLIGHT))
    assert whole["angle"] == "heading" and "CC-BY 4.0" in whole["attribution"]
    course = identified(capsys, str(FLIGHT), "--angle", "course")
    assert course["angle"] == "course" and 0.94 < course["r2"] < whole["r2"]
    without = identified(capsys, str(FLIGHT), "--no-transport")
    assert without["transport"] is False and without["gravity_m_s2"] > whole["gravity_m_s2"] + 0.5
    part = identified(capsys, str(FLIGHT), "--from", "20", "--to", "60")
    assert part["seconds"] == pytest.approx(40.0, abs=1.5)
    assert part["k_rad_per_m_std"] > whole["k_rad_per_m_std"]
    rough = identified(capsys, str(FLIGHT), "--smooth", "0.3")
    assert whole["k_rad_per_m"] < rough["k_rad_per_m"] < 1.02 * whole["k_rad_per_m"]


@pytest.mark.parametrize(("arguments", "message"), [
    (["nowhere"], "nowhere: No such file"),
    (["."], "a folder without truth.csv"),
    ([str(FLIGHT), "--from", "500"], "it lasts 149 s"),
    ([str(FLIGHT), "--from", "20", "--to", "22"], "at least 5 s are needed"),
    ([str(FLIGHT), "--columns", "nowhere.toml"], "nowhere.toml: No such file"),
    ([str(FLIGHT.with_name("README.md"))], "column time is missing"),
    ([str(FLIGHT), "--plot", "/proc/flight.png"], "--plot /proc/flight.png"),
])
def test_what_cannot_be_is_answered_in_a_line(capsys, arguments, message, monkeypatch):
    monkeypatch.chdir(FLIGHT.parent)
    assert message in refused(capsys, *arguments)
