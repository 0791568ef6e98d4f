"""What somebody's program does with mavsdk on a kite: `python mavsdk_session.py PORT`; prints each call's outcome.

A process of its own, because a native library's threads must not outlive a test, nor hang it.
"""

import json
import sys
import threading
import time
from collections.abc import Callable
from enum import IntEnum
from typing import Any

from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.action import Action
from mavsdk.plugins.component_metadata import ComponentMetadata, MetadataType
from mavsdk.plugins.info import Info, InfoError
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import Telemetry

_CONNECT_S = 20.0
_METADATA_S = 15.0
_TOLD_S = 6.0  # a heartbeat comes once a second, some are lost, and a link may take a second


class Outcomes:
    """Outcomes by name of a call: [what came of it, seconds that it took]."""

    def __init__(self) -> None:
        self.by_name: dict[str, tuple[Any, float]] = {}

    def note(self, name: str, call: Callable[[], Any]) -> Any:
        """Make a call and note its value, or the name of its error's result."""
        begin = time.monotonic()
        value = None
        try:
            value = call()
            outcome = getattr(value, "name", value) if isinstance(value, IntEnum) else value
        except Exception as error:
            result = getattr(error, "result", None) or getattr(error, "_result", None)
            outcome = getattr(result, "name", repr(error))
        self.by_name[name] = (outcome, time.monotonic() - begin)
        return value


class ArmedState:
    """What `subscribe_armed` tells."""

    def __init__(self, telemetry: Telemetry):
        self._changed = threading.Condition()
        self._armed: bool | None = None
        telemetry.subscribe_armed(self._take)

    def _take(self, armed: bool, *_: Any) -> None:
        with self._changed:
            self._armed = armed
            self._changed.notify_all()

    def becomes(self, wanted: bool) -> bool:
        """Wait until the kite is told to be armed, or disarmed; whether it was."""
        with self._changed:
            return self._changed.wait_for(lambda: self._armed == wanted, _TOLD_S)


def main(port: str) -> None:
    """Connect, then call one after the other."""
    outcomes = Outcomes()
    mavsdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    mavsdk.add_any_connection(f"udpin://127.0.0.1:{port}")
    system = outcomes.note("connect", lambda: mavsdk.first_autopilot(_CONNECT_S))
    outcomes.by_name["connect"] = (system is not None, outcomes.by_name["connect"][1])
    if system is not None:
        call_everything(system, outcomes)
    print(json.dumps(outcomes.by_name))


def call_everything(system: Any, outcomes: Outcomes) -> None:
    """The calls of this session, in order."""
    param = Param(system)
    action = Action(system)
    telemetry = Telemetry(system)  # kept: its subscriptions end with it
    armed = ArmedState(telemetry)
    outcomes.note("list", lambda: {p.name: p.value for p in param.get_all_params().float_params})
    outcomes.note("set", lambda: param.set_param_float("INNER_P", 2.75))
    outcomes.note("get", lambda: param.get_param_float("INNER_P"))
    outcomes.note("out of range", lambda: param.set_param_float("INNER_P", 1000.0))
    outcomes.note("read-only", lambda: param.set_param_float("TABLE_VERSION", 2.0))
    outcomes.note("unknown", lambda: param.set_param_float("NO_SUCH", 1.0))
    outcomes.note("version", lambda: flight_version(system))
    outcomes.note("metadata", lambda: parameter_metadata(system))
    outcomes.note("disarm first", action.disarm)
    outcomes.note("seen disarmed", lambda: armed.becomes(False))
    outcomes.note("arm", action.arm)
    outcomes.note("seen armed", lambda: armed.becomes(True))
    outcomes.note("disarm", action.disarm)
    outcomes.note("seen disarmed again", lambda: armed.becomes(False))


def flight_version(system: Any) -> list[int]:
    """The firmware's version: major, minor, patch. It is asked for on connecting, and may not have come yet."""
    info = Info(system)
    end = time.monotonic() + _TOLD_S
    while True:
        try:
            version = info.get_version()
        except InfoError:
            if time.monotonic() > end:
                raise
            time.sleep(0.1)
        else:
            return [version.flight_sw_major, version.flight_sw_minor, version.flight_sw_patch]


def parameter_metadata(system: Any) -> dict[str, Any] | None:
    """The parameter JSON, by way of MAVFTP; None when none came."""
    metadata = ComponentMetadata(system)
    came = threading.Event()
    texts: list[str] = []

    def take(update: Any, *_: Any) -> None:
        if update.type == MetadataType.PARAMETER:
            texts.append(update.json_metadata)
            came.set()

    metadata.subscribe_metadata_available(take)
    metadata.request_component(1)  # (4.1.0 asks component 0 for the autopilot's)
    return json.loads(texts[0]) if came.wait(_METADATA_S) else None


if __name__ == "__main__":
    main(sys.argv[1])
    sys.stdout.flush()
