"""A recorded flight is one type, and the same whether it was listened to or read from a log."""

import pytest

from ground.kite import connect_over
from ground.logs.recorder import Recorder
from ground.vehicle.history import StateHistory
from kite_analysis.flights.record import COLUMNS
from kite_analysis.flights.telemetry import for_identification, read_tlog_record
from protocol import dialect


def test_a_flight_is_the_same_live_and_from_its_log(flying_kite, tmp_path):
    path, history = tmp_path / "flight.tlog", StateHistory()
    with connect_over(flying_kite("small-kite-paper", loss=0.05).links(), background=False) as kite:
        kite.session.connection.add_observer(history.observe)
        with Recorder(kite.session.connection, path, 0.0):
            kite.wait(12.0)
    heard = history.record()
    assert set(heard.mode) == {dialect.KITE_MODE_TRACK} and heard.selected.all()
    assert "overruns" in heard.further and len(heard.further["heard_s"]) == len(heard.time_s) == len(history) > 400
    live, read = for_identification(heard), read_tlog_record(path)
    assert type(live) is type(read) is type(heard)
    for name in ("time_s", *COLUMNS):
        assert getattr(live, name) == pytest.approx(getattr(read, name), nan_ok=True), name
    assert live.has("azimuth") and live.has("set_steering") and live.period_s == pytest.approx(0.02, rel=0.2)
