"""What happens before t = 0: on any link and at any rate of the loop, and while ground stations are talking."""

from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from protocol import dialect
from sim_bridge.errors import FirmwareError
from sim_bridge.flight.flight import Flight
from sim_bridge.flight.preflight import Preflight
from sim_bridge.flight.truth_columns import COLUMNS
from sim_bridge.links.ground_path import GroundLink
from sim_bridge.links.link_settings import LinkSettings, PathSettings
from sim_bridge.links.wire import BRIDGE_COMPONENT, BRIDGE_SYSTEM, as_request
from sim_bridge.runs.run import RunOptions, run_scenario
from sim_bridge.runtimes.memory import MemoryRuntime
from sim_bridge.scenario.scenario import Scenario, load_scenario

_LENGTH_S = 0.5


def modes_flown(flight: Flight) -> set[float]:
    return {row[COLUMNS.index("mode")] for row in flight.rows}


@pytest.mark.parametrize("loop_hz", [10.0, 11.0, 12.0, 13.0, 47.0, 200.0])
def test_every_rate_in_the_range_of_loop_hz_flies(loop_hz):
    scenario = load_scenario("paper-no-delay")
    scenario.set("run.duration_s", 12.0, "test")
    scenario.set_parameter("LOOP_HZ", loop_hz, "test")
    result = run_scenario(scenario, RunOptions())
    assert result.numbers["verdict"] == "tracking" and result.numbers["ticks"] == 12 * loop_hz


_VALUES = {
    "delay_s": st.floats(0.0, 1.0), "jitter_s": st.floats(0.0, 0.4), "loss": st.just(0.0) | st.floats(0.0, 1.0),
    "loss_burst": st.floats(0.0, 50.0), "duplicate": st.floats(0.0, 1.0), "reorder": st.floats(0.0, 1.0),
    "reorder_s": st.floats(0.0, 0.5), "rate_bytes_s": st.floats(-3.0, 6.0).map(lambda power: 10.0**power),
}
_LINKS = st.dictionaries(
    st.tuples(st.sampled_from(("", "down.", "up.")), st.sampled_from(sorted(_VALUES))), st.none(), max_size=4
).flatmap(lambda keys: st.fixed_dictionaries({f"link.control.{way}{name}": _VALUES[name] for way, name in keys}))


def keeps_samples_fresh(down: LinkSettings) -> bool:
    """True where no gap between two samples can come near STALE_TIME."""
    wait_s = 2.0 * down.jitter_s + (down.reorder_s if down.reorder else 0.0)
    return not down.loss and wait_s < 0.3 and (not down.rate_bytes_s or down.rate_bytes_s > 500.0)


@settings(max_examples=80, deadline=None)
@given(_LINKS)
@example({"link.control.rate_bytes_s": 3000.0})
@example({"link.control.down.rate_bytes_s": 3000.0, "link.control.down.delay_s": 0.7})
def test_a_kite_takes_off_on_every_link_that_brings_samples_and_says_so_on_the_others(keys):
    scenario = load_scenario("paper-delay-tuned")
    for key, value in {"run.duration_s": _LENGTH_S, **keys}.items():
        scenario.set(key, value, "test")
    try:
        flown = run_scenario(scenario, RunOptions()).flight
    except FirmwareError as error:
        assert not keeps_samples_fresh(scenario.link.control.down)
        assert "refused to" in str(error) and "\n" not in str(error)
    else:
        assert len(flown.rows) == 50 * _LENGTH_S
        if keeps_samples_fresh(scenario.link.control.down):
            assert modes_flown(flown) == {dialect.KITE_MODE_TRACK}


class Talker:
    """A ground station that asks for what is refused in each tick, and for PARK as soon as the kite is armed."""

    def __init__(self) -> None:
        self._mav = dialect.MAVLink(None, srcSystem=255, srcComponent=190)
        self._parser = dialect.MAVLink(None)
        self.answered: list[str] = []
        self._parks = 1

    def receive(self) -> list[bytes]:
        """What it sends in this tick."""
        kind = dialect.MAV_PARAM_TYPE_REAL32
        asked: list[Any] = [
            dialect.MAVLink_param_set_message(1, 1, b"NO_SUCH", 1.0, kind),
            dialect.MAVLink_param_set_message(1, 1, b"INNER_P", -1.0, kind),
            self._command(dialect.MAV_CMD_DO_SET_MODE, 1.0, 77.0)]
        if "armed" in self.answered and self._parks:
            self._parks -= 1
            asked.append(self._command(dialect.MAV_CMD_DO_SET_MODE, 1.0, float(dialect.KITE_MODE_PARK)))
        return [self._frame(message) for message in asked]

    def send(self, frames: list[bytes]) -> None:
        """What it hears."""
        for frame in frames:
            message: Any = self._parser.decode(bytearray(frame))
            kind = message.get_type()
            if kind == "COMMAND_ACK" and message.command == dialect.MAV_CMD_COMPONENT_ARM_DISARM:
                self.answered.append("armed")
            elif kind in ("PARAM_ERROR", "COMMAND_ACK") and message.target_component == 190:
                self.answered.append(f"{kind} {getattr(message, 'result', None)}")

    def _frame(self, message: Any) -> bytes:
        self._mav.seq = (self._mav.seq + 1) % 256
        return message.pack(self._mav)

    def _command(self, command: int, first: float, second: float) -> Any:
        return dialect.MAVLink_command_long_message(1, 1, command, 0, first, second, 0.0, 0.0, 0.0, 0.0, 0.0)


def test_answers_to_another_ground_station_change_nothing():
    scenario = load_scenario("paper-delay-tuned")
    talker = Talker()
    flight = Flight(scenario, MemoryRuntime(), GroundLink(PathSettings(), 1), talker)
    flight.fly(_LENGTH_S)
    assert modes_flown(flight) == {dialect.KITE_MODE_TRACK}
    accepted = f"COMMAND_ACK {dialect.MAV_RESULT_ACCEPTED}"
    assert talker.answered.count(accepted) == 1  # its PARK, which the bridge's TRACK came after
    assert talker.answered.count("PARAM_ERROR None") > 100


@pytest.mark.parametrize("system, component", [(255, 190), (7, BRIDGE_COMPONENT), (BRIDGE_SYSTEM, 1), (0, 0)])
def test_only_answers_to_the_bridge_itself_count(system, component):
    preflight = Preflight(Scenario("test"))
    refused = as_request(dialect.MAVLink_param_error_message(system, component, b"INNER_P", -1, 2))
    accepted = [as_request(dialect.MAVLink_command_ack_message(command, 0, 0, 0, system, component))
                for command in (dialect.MAV_CMD_COMPONENT_ARM_DISARM, dialect.MAV_CMD_DO_SET_MODE)]
    preflight.hear([refused, *accepted])
    assert not preflight.done and not preflight._armed
    refused = as_request(dialect.MAVLink_param_error_message(BRIDGE_SYSTEM, BRIDGE_COMPONENT, b"INNER_P", -1, 2))
    with pytest.raises(FirmwareError, match="refused INNER_P: out of range"):
        preflight.hear([refused])
