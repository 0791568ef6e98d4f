"""The run log: a folder from which a run can be inspected and repeated, written during the flight.

run.json         every value that decides the flight, the code and versions that flew it; at the end, the result
truth.csv        a row a tick, floats written so that they read back to the bit
control.tlog     samples to the firmware, steering and everything else from it
ground.tlog      what reached ground stations, and their frames as they reached the firmware
ground_input.txt in lockstep, the datagrams of ground stations, tick by tick, for `kite-sitl rerun`
wind.csv         a copy of the wind file, if one blows

All files are handed to the operating system twice a second, so that whatever happens to the process, they hold the
flight up to the last second. Nothing that was written is removed, but for the oldest part of a log with a limit:
what truth.old.csv, control.old.tlog and ground.old.tlog hold, when the present parts take their place.
"""

import json
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from kite_analysis.flights.tlog import tlog_entry
from protocol import dialect
from protocol.frame import frame_length
from sim_bridge.errors import ScenarioError
from sim_bridge.flight.tick_record import TickRecord
from sim_bridge.flight.truth_columns import COLUMNS, TruthRow
from sim_bridge.links.wire import BridgeCodec
from sim_bridge.runs.growing_files import GrowingFiles
from sim_bridge.runs.input_budget import InputBudget
from sim_bridge.runs.provenance import WIND_COPY, what_decides
from sim_bridge.scenario.scenario import Scenario

FORMAT = 2
RUN, TRUTH, INPUT = "run.json", "truth.csv", "ground_input.txt"
COMPLETE_BEFORE = "# "  # a line of ground_input.txt: all datagrams of the ticks before this one stand above
HEADER = ",".join(COLUMNS) + "\n"
_COMMIT_S = 0.5
_LIMITED = (1, 2, 3)  # truth, control, ground; datagrams have their own limit


class RunLog:
    """Writes the log of one run into `folder`, which must be new or empty; `limit_bytes` is the most it may take.

    A disk that is full ends the log and not the flight; `notice` is told.

    Raises:
        ScenarioError: the folder cannot be used.
    """

    def __init__(self, folder: Path, notice: Callable[[str], None], limit_bytes: float = float("inf")):
        self.folder = folder
        self.recorded_s = 0.0  # the log holds the flight up to here
        self.ended: str | None = None  # why it holds no more, if it ended before the flight
        self._notice = notice
        self._limit_bytes = limit_bytes
        self._files: GrowingFiles | None = None
        self._about: dict[str, Any] = {}
        self._codec = BridgeCodec()
        self._epoch_us = time.time_ns() // 1000
        self._budget = InputBudget()
        self._records_input = self._is_flooded = False
        self._next_tick, self._last_s = 0, float("-inf")
        self._committed_s = float("-inf")
        self._committed_at = time.monotonic()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if any(folder.iterdir()):
                raise ScenarioError(f"--log {folder}: not empty; give a new folder")
        except OSError as error:
            raise self._unusable(error) from error

    def begin(self, scenario: Scenario, about: dict[str, Any]) -> None:
        """Create the files, with run.json for the coming flight.

        Raises:
            ScenarioError: they cannot be made.
        """
        self._about = {"format": FORMAT, "complete": False, "started_us": self._epoch_us, **about,
                       **what_decides(scenario)}
        self._records_input = about["ground"] and not about["real_time"]
        names = (INPUT, TRUTH, "control.tlog", "ground.tlog")
        try:
            if scenario.wind.file:
                (self.folder / WIND_COPY).write_bytes(Path(scenario.wind.file).read_bytes())
            self._write_about()
            self._files = GrowingFiles([self.folder / name for name in names], [b"", HEADER.encode(), b"", b""])
        except OSError as error:
            raise self._unusable(error) from error

    def watch(self, record: TickRecord) -> None:
        """Log a tick."""
        if self._files is None:
            return
        lines, frames = self._from_stations(record)
        frames += b"".join(tlog_entry(self._stamp(record.time_s), frame) for frame in record.heard)
        row = format_row(record.row).encode() if record.row else b""
        self._files.add(lines, row, self._control(record), frames)
        self._next_tick, self._last_s = record.tick + 1, record.time_s
        now = time.monotonic()
        if record.time_s - self._committed_s >= _COMMIT_S or now - self._committed_at >= _COMMIT_S:
            self._committed_s, self._committed_at = record.time_s, now
            self._commit()

    def finish(self, ended: str, result: dict[str, Any]) -> None:
        """Write the rest, and in run.json why the flight ended, and its result."""
        if self._files is None and not self.ended:
            return
        self._commit()
        if self._files is not None:
            self._files.close()
            self._files = None
        self._about |= {"complete": True, "ended": ended, "log_ended": self.ended,
                        "ground_bytes_left_out": self._budget.left_out, **result}
        try:
            self._write_about()
        except OSError as error:
            if not self.ended:  # else it was said
                self._notice(f"log {self.folder}: {RUN} not updated after the flight: {error.strerror}")

    def _commit(self) -> None:
        files = self._files
        if files is None:
            return
        if self._records_input:
            files.add(f"{COMPLETE_BEFORE}{self._next_tick}\n".encode(), b"", b"", b"")
        self._guarded(files.commit)
        if self.ended or not files.sizes:  # closed already, if Ctrl-C came on the way out
            return
        self.recorded_s = max(0.0, self._last_s)
        if sum(files.sizes[index] for index in _LIMITED) > 0.5 * self._limit_bytes:
            for index in _LIMITED:
                self._guarded(partial(files.start_again, index))

    def _guarded(self, action: Callable[[], None]) -> None:
        """Do something to the files; if the disk is full, or gone, the log ends with what it has."""
        if self._files is None:
            return
        try:
            action()
        except OSError as error:
            self.ended = error.strerror or str(error)
            self._files.close()
            self._files = None
            self._notice(f"log {self.folder}: {self.ended}: the flight goes on, but nothing after "
                         f"{self.recorded_s:.1f} s of it is recorded")

    def _from_stations(self, record: TickRecord) -> tuple[bytes, bytes]:
        """What goes into ground_input.txt and ground.tlog of a tick's datagrams, as far as there is room."""
        lines, frames = b"", b""
        for datagram in record.datagrams:
            if not self._budget.claim_room(record.time_s, len(datagram)):
                lines += self._flooded(record)
                continue
            if self._records_input:
                lines += f"{record.tick} {datagram.hex()}\n".encode()
            if _is_frame(datagram):
                frames += tlog_entry(self._stamp(record.time_s), datagram)
        return lines, frames

    def _flooded(self, record: TickRecord) -> bytes:
        """There is no room for a datagram: say so once, and end ground_input.txt, which is of use only without gaps."""
        if self._is_flooded:
            return b""
        self._is_flooded = True
        text = f"log {self.folder}: ground stations send more than {self._budget.text}: some of it is not recorded"
        if not self._records_input:
            self._notice(text)
            return b""
        self._records_input = False
        self._notice(f"{text}; a rerun repeats up to {max(0.0, record.time_s):.1f} s of the flight")
        return f"{COMPLETE_BEFORE}{record.tick}\n".encode()

    def _control(self, record: TickRecord) -> bytes:
        stamp = self._stamp(record.time_s)
        entries = [tlog_entry(stamp, self._codec.encode(dialect.MAVLINK_MSG_ID_KITE_SENSORS, sample))
                   for sample in record.samples]
        for sent_s, steering in record.output.steering:
            frame = self._codec.encode_message(dialect.MAVLink_hil_actuator_controls_message(
                round(max(0.0, sent_s) * 1e6), [steering] + [0.0] * 15, 0, 1))
            entries.append(tlog_entry(self._stamp(sent_s), frame))
        entries += [tlog_entry(stamp, frame) for frame in record.output.frames]
        return b"".join(entries)

    def _stamp(self, time_s: float) -> int:
        return self._epoch_us + round(time_s * 1e6)

    def _write_about(self) -> None:
        """Write run.json in one step: there is always a whole one."""
        new = self.folder / f"{RUN}.new"
        try:
            new.write_text(json.dumps(self._about, indent=2) + "\n", "utf-8")
            new.replace(self.folder / RUN)
        except OSError:
            new.unlink(missing_ok=True)
            raise

    def _unusable(self, error: OSError) -> ScenarioError:
        return ScenarioError(f"--log {self.folder}: {error.strerror}")


def format_row(row: TruthRow) -> str:
    """A line of truth.csv."""
    return ",".join(repr(value) for value in row) + "\n"


def _is_frame(datagram: bytes) -> bool:
    try:
        return frame_length(datagram) == len(datagram)
    except ValueError:
        return False
