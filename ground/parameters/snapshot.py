"""The parameters as they were when this flight began, kept on disk so that kite-ground can restore them later.

One file per vehicle, `system-ID.param` in the user's state folder, in MAVProxy's form. It is taken once, by the first
verb that changes parameters, and holds until the vehicle restarts, `kite-ground arm` begins a flight, or
`kite-ground param snapshot` replaces it. The snapshots that it replaces are kept beside it.
"""

import os
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from ground.errors import NoAnswerError, UsageError
from ground.link.connection import VehicleClock
from ground.parameters.client import ParameterClient
from ground.parameters.file import ParameterFileError, scan_parameter_file, write_parameter_file
from ground.parameters.listing import Progress
from protocol.contract import CONTRACT_HASH

_KEPT = 10  # earlier snapshots per vehicle
_CLOCK_S, _CLOCK_SHARE = 3.0, 0.002  # tolerated offset and drift between two clocks
_UPTIME_WAIT_S = 4.0
_FAST = 1.5


class Snapshot(NamedTuple):
    """Values by name. Taken at `taken_s` (seconds since 1970), when the vehicle had been running for `uptime_s`.

    `complete`: has all of the vehicle's parameters, not only those saved before a change.
    """

    values: dict[str, float]
    taken_s: float
    uptime_s: float
    complete: bool


class SnapshotStore:
    """Takes and finds the snapshot of the vehicle whose parameters `client` reads.

    `warn` receives one-line warnings. `file` overrides where the snapshot is kept; `now` gives seconds since 1970.
    """

    def __init__(self, client: ParameterClient, warn: Callable[[str], None], file: str | Path | None = None,
                 now: Callable[[], float] = time.time) -> None:
        self.path = Path(file) if file else state_folder() / f"system-{client.connection.target.system}.param"
        self._client, self._warn, self._now, self._stated = client, warn, now, file is not None

    def find(self) -> Snapshot | None:
        """The valid snapshot, of this vehicle since its start; None if there is none.

        Raises:
            ParameterFileError: the file exists but cannot be read.
        """
        if not self.path.exists():
            return None
        snapshot = read_snapshot(self.path)
        return snapshot if self._stated or not self._is_of_another_start(snapshot) else None

    def protect(self, name: str) -> float:
        """Save `name` in the snapshot before it is changed, with a single exchange; return its present value."""
        value = self._client.fetch(name)
        snapshot = self.find()
        if snapshot is None:
            self._write({name: value}, complete=False)
        elif name not in snapshot.values:
            self._write({**snapshot.values, name: value}, snapshot.complete, snapshot)
        return value

    def complete(self, values: dict[str, float]) -> None:
        """Add the missing parameters to the snapshot, from the vehicle's present `values`."""
        snapshot = self.find()
        if snapshot is None:
            self._write(values, complete=True)
        elif not snapshot.complete:
            self._write({**values, **snapshot.values}, True, snapshot)

    def finish(self, progress: Progress | None = None) -> None:
        """Fetch the parameters that the snapshot lacks. If the vehicle does not answer, only warn."""
        snapshot = self.find()
        if snapshot is not None and snapshot.complete:
            return
        try:
            self.complete(self._client.fetch_all(progress))
        except NoAnswerError as error:
            self._warn(f"the snapshot is not complete: {error}")

    def renew(self, progress: Progress | None = None) -> dict[str, float]:
        """Replace the snapshot by the vehicle's present values; return them."""
        values = self._client.fetch_all(progress)
        self._write(values, complete=True)
        return values

    def _is_of_another_start(self, snapshot: Snapshot) -> bool:
        """Whether, by its clock, the vehicle has restarted since, or is another vehicle with the same id."""
        uptime_s = self._uptime()
        if uptime_s is None:
            return False
        elapsed_s = max(self._now() - snapshot.taken_s, 0.0)
        ahead_s = uptime_s - snapshot.uptime_s - elapsed_s
        slack_s = _CLOCK_S + _CLOCK_SHARE * elapsed_s
        return ahead_s < -slack_s or (ahead_s > slack_s and not self._runs_fast())

    def _uptime(self) -> float | None:
        """How long the vehicle has been running [s], from its answers to TIMESYNC; None without an answer."""
        connection = self._client.connection
        connection.wait_until(lambda: connection.vehicle_clock is not None, _UPTIME_WAIT_S)
        if connection.vehicle_clock is None:
            return None
        return connection.vehicle_clock.uptime_s + connection.clock() - connection.vehicle_clock.heard_s

    def _runs_fast(self) -> bool:
        """Whether the vehicle's clock runs faster than ours, as in a simulation."""
        connection = self._client.connection
        first = connection.vehicle_clock or VehicleClock(0.0, 0.0)
        connection.wait_until(lambda: (connection.vehicle_clock or first).heard_s > first.heard_s + 0.9, _UPTIME_WAIT_S)
        last = connection.vehicle_clock or first
        return last.uptime_s - first.uptime_s > _FAST * (last.heard_s - first.heard_s)

    def _write(self, values: dict[str, float], complete: bool, earlier: Snapshot | None = None) -> None:
        taken_s, uptime_s = (earlier.taken_s, earlier.uptime_s) if earlier else (self._now(), self._uptime() or 0.0)
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            if earlier is None:
                self._put_aside()
        except OSError as error:
            raise UsageError(f"{self.path}: cannot write the snapshot: {error.strerror}; "
                             "give another file with --snapshot") from None
        write_parameter_file(self.path, values, (
            f"kitepilot snapshot of system {self._client.connection.target.system}, contract {CONTRACT_HASH}",
            f"taken: {datetime.fromtimestamp(taken_s, UTC).isoformat()}", f"uptime: {uptime_s:.3f}",
            f"complete: {'yes' if complete else 'no'}"))

    def _put_aside(self) -> None:
        """Rename the existing snapshot by its date, and keep the latest few of these."""
        if self._stated or not self.path.exists():
            return
        stamp = datetime.fromtimestamp(self.path.stat().st_mtime, UTC).strftime("%Y%m%d-%H%M%S")
        self.path.replace(self.path.with_name(f"{self.path.stem}-{stamp}.param"))
        for old in sorted(self.path.parent.glob(f"{self.path.stem}-*.param"))[:-_KEPT]:
            old.unlink()


def state_folder() -> Path:
    """The folder of snapshots: below $XDG_STATE_HOME, or ~/.local/state."""
    base = os.environ.get("XDG_STATE_HOME")
    return (Path(base) if base else Path.home() / ".local" / "state") / "kitepilot"


def read_snapshot(path: Path) -> Snapshot:
    """Read a snapshot; a parameter file without a date counts as taken when it was last written.

    Raises:
        ParameterFileError: it cannot be read, or a line is malformed.
    """
    entries, problems = scan_parameter_file(path)
    if problems:
        number, problem = problems[0]
        raise ParameterFileError(f"{path}:{number}: {problem}; give another snapshot with --snapshot, or remove "
                                 "this one")
    facts = {}
    for line in path.read_text("utf-8-sig").splitlines():
        if line.startswith("#"):
            key, _, text = line[1:].partition(":")
            facts[key.strip()] = text.strip()
    try:
        taken_s = datetime.fromisoformat(facts["taken"]).timestamp() if "taken" in facts else path.stat().st_mtime
        uptime_s = float(facts.get("uptime", "0"))
    except ValueError:
        raise ParameterFileError(f"{path}: its time cannot be read: remove it, or give another --snapshot") from None
    values = {name: entry.value for name, entry in entries.items()}
    return Snapshot(values, taken_s, uptime_s, facts.get("complete", "yes") == "yes")


def describe_age(snapshot: Snapshot, now_s: float) -> str:
    """When the snapshot was taken, in words."""
    minutes = max(now_s - snapshot.taken_s, 0.0) / 60.0
    at = datetime.fromtimestamp(snapshot.taken_s).astimezone().strftime("%Y-%m-%d %H:%M:%S")
    return f"{at}, {minutes:.0f} min ago" if minutes >= 1.0 else f"{at}, just now"
