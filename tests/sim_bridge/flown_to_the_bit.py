"""Flies with the loop that it is told, in a process of its own, and says what came out, to the last bit.

`python -m tests.sim_bridge.flown_to_the_bit compiled|interpreted`, with a JSON list of flights on the standard input:
each has `scenario`, `seconds`, and perhaps `runtime`, `set` (keys), `param` (parameters). A flight with `talk`, a seed,
is one in which a ground station of that seed sends all sorts of things. Prints a JSON list of [loop, fingerprint].
"""

import json
import random
import sys
from hashlib import sha256
from typing import Any

from sim_bridge.native.choice import choose_loop, loop_in_use

_UNKNOWN_COMMAND = 410
PROBLEM = choose_loop(sys.argv[1] == "interpreted") if __name__ == "__main__" else None


def flown(flight: dict[str, Any]) -> str:
    """Fingerprint of the truth at each tick and of the flight's numbers; or why it could not be flown."""
    from sim_bridge.errors import FirmwareError, ScenarioError  # noqa: PLC0415  after the choice
    from sim_bridge.flight.flight import Flight  # noqa: PLC0415
    from sim_bridge.runs.run import make_runtime  # noqa: PLC0415
    from sim_bridge.scenario.scenario import load_scenario  # noqa: PLC0415

    scenario = load_scenario(flight["scenario"])
    for key, value in flight.get("set", {}).items():
        scenario.set(key, value, "test")
    for name, value in flight.get("param", {}).items():
        scenario.set_parameter(name, value, "test")
    try:
        runtime = make_runtime(flight.get("runtime", "inproc"), False, False)
        try:
            runtime.start()
            one = Flight(scenario, runtime)
            one.fly(flight["seconds"])
        finally:
            runtime.stop()
    except (ScenarioError, FirmwareError) as error:
        return str(error)
    digest = sha256()
    for row in one.rows:
        digest.update(",".join(value.hex() for value in row).encode())
    return f"{len(one.truth)} {digest.hexdigest()} {one.metrics()}"


def talked(flight: dict[str, Any]) -> str:
    """Fingerprint of every byte that the firmware sends in a flight with a talkative ground station."""
    from sim_bridge.flight.flight import Flight  # noqa: PLC0415
    from sim_bridge.links.ground_path import GroundLink  # noqa: PLC0415
    from sim_bridge.links.link_settings import PathSettings  # noqa: PLC0415
    from sim_bridge.runtimes.memory import MemoryRuntime  # noqa: PLC0415
    from sim_bridge.scenario.scenario import load_scenario  # noqa: PLC0415

    digest = sha256()
    ground = GroundLink(PathSettings(), 1)
    said = random.Random(flight["talk"])
    one = Flight(load_scenario(flight["scenario"]), MemoryRuntime(), ground,
                 watch=lambda tick: digest.update(b"".join(tick.output.frames)))
    station = _Station(said)
    one.fly(0.0)
    while one.time_s < flight["seconds"]:
        for datagram in station.datagrams():
            ground.from_station(one.time_s, datagram)
        one.step()
    for row in one.rows:
        digest.update(",".join(value.hex() for value in row).encode())
    return digest.hexdigest()


class _Station:
    """Sends, at random: parameters, commands, questions, sticks, frames of any message, and noise."""

    def __init__(self, said: random.Random):
        from protocol import dialect  # noqa: PLC0415
        from protocol.parameter_table import load_parameters  # noqa: PLC0415

        self._said = said
        self._dialect = dialect
        self._mav = dialect.MAVLink(None, srcSystem=255, srcComponent=190)
        self._table = load_parameters()

    def datagrams(self) -> list[bytes]:
        """What it sends in a tick."""
        return [self._datagram() for _ in range(self._said.choice((0, 0, 0, 1, 1, 2, 9)))]

    def _datagram(self) -> bytes:
        kind = self._said.random()
        if kind < 0.05:
            return self._said.randbytes(self._said.randint(1, 80))
        if kind < 0.25:
            return self._any_message().pack(self._mav)
        return self._request().pack(self._mav)

    def _request(self) -> Any:
        said, dialect = self._said, self._dialect
        name = said.choice(list(self._table))
        entry = self._table[name]
        value = said.choice((entry.default, entry.least, entry.greatest, said.uniform(entry.least, entry.greatest),
                             float("nan"), 1e9))
        command = said.choice((
            dialect.MAV_CMD_COMPONENT_ARM_DISARM, dialect.MAV_CMD_DO_SET_MODE, dialect.MAV_CMD_PREFLIGHT_STORAGE,
            dialect.MAV_CMD_SET_MESSAGE_INTERVAL, dialect.MAV_CMD_REQUEST_MESSAGE, _UNKNOWN_COMMAND))
        first, second = (said.choice((0.0, 1.0, 2.0, 3.0, 50010.0, 1e6, said.uniform(-2.0, 9.0))) for _ in range(2))
        return said.choice((
            dialect.MAVLink_param_set_message(1, 1, name.encode(), value, dialect.MAV_PARAM_TYPE_REAL32),
            dialect.MAVLink_param_request_read_message(1, 1, name.encode(), said.choice((-1, 0, 7, 900))),
            dialect.MAVLink_param_request_list_message(1, 1),
            dialect.MAVLink_command_long_message(1, 1, command, 0, first, second, 0, 0, 0, 0, 0),
            dialect.MAVLink_command_int_message(1, 1, 0, command, 0, 0, first, second, 0, 0, 1, 2, 0),
            dialect.MAVLink_manual_control_message(1, said.randint(-1000, 1000), said.randint(-1000, 1000), 0, 0, 0),
            dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3),
            dialect.MAVLink_timesync_message(0, said.randint(0, 1 << 40)),
            dialect.MAVLink_ping_message(said.randint(0, 1 << 40), 1, 0, 0),
            dialect.MAVLink_mission_request_list_message(1, 1),
            dialect.MAVLink_radio_status_message(50, 50, said.randint(0, 255), 1, 1, 0, 0),
            dialect.MAVLink_file_transfer_protocol_message(0, 1, 1, list(said.randbytes(251)))))

    def _any_message(self) -> Any:
        """A message of the dialect with random fields."""
        kind = self._dialect.mavlink_map[self._said.choice(sorted(self._dialect.mavlink_map))]
        return kind(*[self._field(field, length)
                      for field, length in zip(kind.fieldtypes, _lengths(kind), strict=True)])

    def _field(self, field: str, length: int) -> Any:
        if field == "char":
            return self._said.randbytes(length)
        values = [self._said.uniform(-1e3, 1e3) if field in ("float", "double") else
                  self._said.randint(0, 127) for _ in range(max(1, length))]
        return values if length else values.pop()


def _lengths(kind: Any) -> list[int]:
    """Lengths of the arrays among a message's fields, 0 for what is none."""
    by_name = dict(zip(kind.ordered_fieldnames, kind.array_lengths, strict=True))
    return [by_name[name] for name in kind.fieldnames]


def main() -> None:
    """Fly what is asked."""
    if PROBLEM:
        sys.exit(PROBLEM)
    found = [talked(flight) if "talk" in flight else flown(flight) for flight in json.load(sys.stdin)]
    print(json.dumps([[loop_in_use(), fingerprint] for fingerprint in found]))


if __name__ == "__main__":
    main()
