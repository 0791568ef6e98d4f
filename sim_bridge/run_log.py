"""The run log: a folder from which a run can be looked at and flown again.

run.json         the scenario as resolved, runtime, seed, versions, and the result
truth.csv        a row a tick, floats written so that they read back to the bit
control.tlog     samples to the firmware, steering and everything else from it
ground.tlog      what reached ground stations, and their frames as they reached the firmware
ground_input.txt the datagrams of ground stations, tick by tick, for `kite-sitl rerun`
"""

import json
import platform
import time
from importlib import metadata
from pathlib import Path
from typing import Any

from analysis.tlog import TlogWriter, frame_length
from protocol import dialect
from protocol.contract import CONTRACT_HASH
from sim_bridge.flight import COLUMNS, TickRecord
from sim_bridge.scenario import Scenario, ScenarioError
from sim_bridge.wire import BridgeCodec

_FORMAT = 1


class RunLog:
    """Writes the log of one run into `folder`, which must be new or empty.

    Raises:
        ScenarioError: the folder cannot be used.
    """

    def __init__(self, folder: Path):
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if any(folder.iterdir()):
                raise ScenarioError(f"--log {folder}: not empty; name a new folder")
            self._control = TlogWriter(folder / "control.tlog")
            self._ground = TlogWriter(folder / "ground.tlog")
            self._input = (folder / "ground_input.txt").open("w", encoding="ascii")
        except OSError as error:
            raise ScenarioError(f"--log {folder}: {error.strerror}") from error
        self._epoch_us = time.time_ns() // 1000
        self._codec = BridgeCodec()

    def watch(self, record: TickRecord) -> None:
        """Log a tick."""
        stamp = self._epoch_us + round(record.time_s * 1e6)
        for sample in record.samples:
            self._control.write(stamp, self._codec.encode(dialect.MAVLINK_MSG_ID_KITE_SENSORS, sample))
        for sent_s, steering in record.output.steering:
            frame = self._codec.encode_message(dialect.MAVLink_hil_actuator_controls_message(
                round(max(0.0, sent_s) * 1e6), [steering] + [0.0] * 15, 0, 1))
            self._control.write(self._epoch_us + round(sent_s * 1e6), frame)
        for frame in record.output.frames:
            self._control.write(stamp, frame)
        for datagram in record.datagrams:
            self._input.write(f"{record.tick} {datagram.hex()}\n")
            if _is_frame(datagram):
                self._ground.write(stamp, datagram)
        for frame in record.heard:
            self._ground.write(stamp, frame)

    def discard(self) -> None:
        """The run failed: leave nothing behind that looks like a log."""
        for file in (self._control, self._ground, self._input):
            file.close()
        for path in self.folder.iterdir():
            path.unlink()

    def finish(self, scenario: Scenario, rows: list[tuple[float, ...]], about: dict[str, Any]) -> None:
        """Write the truth and what the run was, and close all files."""
        self._control.close()
        self._ground.close()
        self._input.close()
        with (self.folder / "truth.csv").open("w", encoding="ascii") as file:
            file.write(",".join(COLUMNS) + "\n")
            file.writelines(format_row(row) for row in rows)
        content = {
            "format": _FORMAT, "scenario": scenario.to_dict(), "started_us": self._epoch_us,
            "versions": _versions(), **about}
        (self.folder / "run.json").write_text(json.dumps(content, indent=2) + "\n", "utf-8")


def format_row(row: tuple[float, ...]) -> str:
    """A line of truth.csv."""
    return ",".join(repr(value) for value in row) + "\n"


def read_run(folder: Path) -> tuple[dict[str, Any], Scenario, dict[int, list[bytes]]]:
    """A log's run.json, its scenario, and the ground stations' datagrams by tick.

    Raises:
        ScenarioError: this is not a run log, or not one that this version reads.
    """
    where = str(folder / "run.json")
    try:
        content = json.loads((folder / "run.json").read_text("utf-8"))
        lines = (folder / "ground_input.txt").read_text("ascii").splitlines()
    except OSError as error:
        raise ScenarioError(f"{error.filename}: {error.strerror}; {folder} is not a run log") from error
    except ValueError as error:
        raise ScenarioError(f"{where}: broken: {error}") from error
    if not isinstance(content, dict) or content.get("format") != _FORMAT:
        raise ScenarioError(f"{where}: not a run log of format {_FORMAT}")
    datagrams: dict[int, list[bytes]] = {}
    for line in lines:
        tick, _, text = line.partition(" ")
        datagrams.setdefault(int(tick), []).append(bytes.fromhex(text))
    return content, Scenario.from_dict(content["scenario"], where), datagrams


def _is_frame(datagram: bytes) -> bool:
    try:
        return frame_length(datagram) == len(datagram)
    except ValueError:
        return False


def _versions() -> dict[str, str]:
    packages = {name: metadata.version(name) for name in ("kitepilot", "numpy", "pymavlink")}
    return {"python": platform.python_version(), "contract": CONTRACT_HASH, **packages}
