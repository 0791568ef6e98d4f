"""What a researcher calls from a notebook, against the real firmware; the example in the documentation among it."""

import contextlib
import importlib.util
import socket
import threading
from pathlib import Path

import numpy as np
import pytest

import ground
from ground.kite import connect_over
from protocol import dialect
from protocol.parameter_table import load_parameters

LONG_S = 30.0  # never waited for where things work
EXAMPLE = Path(__file__).parents[2] / "docs" / "examples" / "fly_and_tune.py"


@pytest.fixture
def kite(simulated_kite):
    """Connected through a link that loses a tenth each way."""
    with connect_over(simulated_kite(loss=0.1, round_trip_s=0.2).links(), background=False) as connected:
        yield connected


def test_parameters_are_read_written_kept_and_taken_back(kite, tmp_path):
    defaults = {name: entry.default for name, entry in load_parameters().items()}
    assert kite.parameters.snapshot == kite.parameters.list() == defaults
    kite.parameters["INNER_P"] = 2.5
    assert kite.parameters["INNER_P"] == kite.parameters.get("INNER_P") == 2.5
    kite.parameters.save(tmp_path / "mine.params", "qgroundcontrol")
    assert [change.name for change in kite.parameters.set_all({"INNER_P": 3.0, "OUTER_L": 5.0})] == ["INNER_P"]
    assert kite.parameters.diff() == {"INNER_P": (3.0, 1.5)}
    assert kite.parameters.load(tmp_path / "mine.params")[0].before == 3.0
    assert kite.parameters["INNER_P"] == 2.5
    kite.parameters.revert()
    assert kite.parameters.diff() == {}
    assert kite.parameters.describe("INNER_P").unit == "1/s"
    with pytest.raises(ground.VehicleError, match=r"99 is outside 0\.0625 to 50"):
        kite.parameters["INNER_P"] = 99.0
    with pytest.raises(ground.UsageError, match=r"no parameter is called 'INNER_PP'; did you mean INNER_P\?"):
        kite.parameters["INNER_PP"] = 1.0
    with pytest.raises(ground.UsageError, match="the kite has no parameter INNER_PP"):
        kite.parameters.set_all({"OUTER_L": 9.0, "INNER_PP": 1.0})
    (tmp_path / "bad.param").write_text("OUTER_L 9\nSTEER_MAX 7\n")
    with pytest.raises(ground.UsageError, match=r"bad.param:2: STEER_MAX = 7 is outside .*; nothing was set"):
        kite.parameters.load(tmp_path / "bad.param")
    assert kite.parameters["OUTER_L"] == 5.0


def test_modes_and_waiting(kite):
    """Arm, fly, wait for what comes and for what does not, and be told what was waited for."""
    kite.arm()
    assert kite.armed and kite.mode == "PARK"
    kite.set_mode("track")
    assert kite.wait_for(lambda state: state.mode == dialect.KITE_MODE_TRACK, 5.0).mode == dialect.KITE_MODE_TRACK
    with pytest.raises(ground.NoAnswerError, match=r"^a dive: did not happen within 2 s, in \d+ states of the kite$"):
        kite.wait_for(lambda state: state.elevation < -1.0, 2.0, what="a dive")
    with pytest.raises(ground.UsageError, match="no mode 'LOITER': must be one of STANDBY"):
        kite.set_mode("LOITER")
    kite.parameters["STATE_HZ"] = 0.0
    kite.wait(1.0)
    with pytest.raises(ground.NoAnswerError, match=r"a dive: no KITE_STATE received: .* or is STATE_HZ 0"):
        kite.wait_for(lambda state: True, 2.0, what="a dive")
    kite.disarm()
    assert not kite.armed


def test_history_and_link_tell_what_was_flown(kite):
    """The kite of this simulation hangs still: a minute of its states, with the tenth that is lost missing."""
    kite.wait(60.0)
    last = kite.history.record(seconds=30.0)
    assert len(last.time_s) == pytest.approx(0.9 * 30 * 50, rel=0.03)
    assert np.all(np.diff(last.time_s) > 0.0) and np.ptp(last.time_s) == pytest.approx(30.0, abs=0.1)
    assert last.azimuth == pytest.approx(0.1) and last.airspeed == pytest.approx(20.0)
    assert last.sample_age_s == pytest.approx(0.0, abs=1e-6)
    assert len(kite.history["course"]) == len(kite.history) > len(last.time_s)
    link = kite.link()
    assert link.loss == pytest.approx(0.1, abs=0.06) and link.rate_hz == pytest.approx(0.9 * 57, rel=0.1)
    assert link.round_trip and link.round_trip.median_s == pytest.approx(0.2, abs=0.03)
    assert link.round_trip.loss == pytest.approx(1.0 - 0.9**2, abs=0.12)


def test_the_example_flies_and_tunes(flying_kite, capsys):
    """P starts well below the optimum of a loop of 0.2 s: a tenth more tracks better, and is kept."""
    specification = importlib.util.spec_from_file_location("fly_and_tune", EXAMPLE)
    assert specification and specification.loader
    example = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(example)
    flying = flying_kite("paper-delay", INNER_P=1.2)
    with connect_over(flying.links(), background=False) as kite:
        example.fly_and_tune(kite)
    said = capsys.readouterr().out
    assert "loop delay 0.200 s: P = 1.2, best 1.75, limit 7.48 1/s" in said
    assert "worse" not in said and "spread" in said
    assert flying.firmware_parameter("INNER_P") == pytest.approx(1.32)


def test_a_notebook_may_read_all_the_time_while_the_kite_talks(simulated_kite):
    """The history is long, so that a copy of it takes its time; 100 copies are made while more states come."""
    with connect_over(simulated_kite(loss=0.0, round_trip_s=0.0).links()) as kite:
        kite.wait_for(lambda state: True, 5.0)
        state = kite.state.kite
        assert state is not None
        for _ in range(50_000):
            kite.history.observe(kite.session.connection.clock(), state, b"")
        copies, grown, links = [], len(kite.history), []
        while len(copies) < 100 or len(kite.history) < grown + 500:
            flight = kite.history.record()
            copies.append(len(flight.time_s))
            assert np.all(np.diff(flight.time_s[-5000:]) >= 0.0) and len(flight.course) == copies[-1]
            links.append(kite.link())
            kite.history.record(seconds=1.0)
        kite.wait(1.0)
        assert copies == sorted(copies) and copies[-1] > copies[0]
        assert links[-1].rate_hz > 40.0 and links[-1].loss == 0.0


def serve(kite, vehicle: socket.socket, over: threading.Event) -> None:
    """Fly `kite` on the wall clock, four times as fast, with its radio on a socket."""
    while not over.wait(0.005):
        with contextlib.suppress(BlockingIOError, ConnectionError):
            while True:
                kite.radios[0].send(vehicle.recv(2000))
        kite.step()
        for frame in kite.radios[0].arrived:
            with contextlib.suppress(ConnectionError):  # nobody listens yet
                vehicle.send(frame)
        kite.radios[0].arrived.clear()


def test_a_notebook_may_think_while_the_kite_is_heard_and_hears_us(simulated_kite):
    """Over real sockets: nobody calls anything for two hundred states; none is missed, and our heart beats on."""
    simulated, over, grown = simulated_kite(loss=0.0, round_trip_s=0.0), threading.Event(), threading.Event()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vehicle:
        vehicle.bind(("127.0.0.1", 0))
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        vehicle.connect(("127.0.0.1", port))
        vehicle.setblocking(False)
        flying = threading.Thread(target=serve, args=(simulated, vehicle, over))
        flying.start()
        try:
            with ground.connect(f"udpin:127.0.0.1:{port}", timeout_s=LONG_S) as kite:
                began, sent = len(kite.history), simulated.radios[0].sent
                kite.session.connection.add_observer(
                    lambda time_s, message, frame: grown.set() if len(kite.history) > began + 200 else None)
                assert grown.wait(LONG_S)
                assert simulated.radios[0].sent > sent
                assert np.diff(kite.history["time_us"]).max() == 20000
                kite.parameters["INNER_P"] = 2.5
                assert simulated.firmware_parameter("INNER_P") == 2.5
        finally:
            over.set()
            flying.join()
