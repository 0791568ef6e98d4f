"""The parameters of a connected kite, for scripts and notebooks."""

from collections.abc import Mapping
from pathlib import Path

from ground.errors import UsageError, VehicleError
from ground.link.background import Background
from ground.parameters.changes import Change, ChangeState
from ground.parameters.check import CheckedFile
from ground.parameters.client import ParameterClient
from ground.parameters.file import write_parameter_file
from kite_analysis.console.mistakes import closest
from protocol.contract import CONTRACT_HASH
from protocol.parameter_table import Parameter
from protocol.single_precision import float32


class Parameters:
    """Reads and writes parameters; a value is written only when the vehicle has acknowledged it.

    `snapshot` holds all values as they were on connecting; `revert` restores them. All functions raise VehicleError if
    the vehicle refuses, and NoAnswerError if it does not answer.
    """

    def __init__(self, client: ParameterClient, serving: Background) -> None:
        self.snapshot: dict[str, float] = {}
        self._client, self._serving = client, serving

    def __getitem__(self, name: str) -> float:
        return self.get(name)

    def __setitem__(self, name: str, value: float) -> None:
        self.set(name, value)

    def get(self, name: str) -> float:
        """The vehicle's present value, in the unit given by `describe`."""
        with self._serving.held():
            return self._client.fetch(self._known(name))

    def set(self, name: str, value: float) -> float:
        """Write a value, and return it as acknowledged, a float32."""
        with self._serving.held():
            return self._client.set(self._known(name), value)

    def list(self) -> dict[str, float]:
        """All present values, in the vehicle's order."""
        with self._serving.held():
            return self._client.fetch_all()

    def describe(self, name: str) -> Parameter:
        """Unit, limits, default and documentation of a parameter."""
        return self._client.table[self._known(name)]

    def set_all(self, values: Mapping[str, float]) -> "list[Change]":
        """Write those of `values` that differ from the present ones, and return each with its outcome.

        Raises:
            UsageError: the vehicle lacks one of them; nothing was sent.
            VehicleError: some were refused (the others are written), or not answered.
        """
        with self._serving.held():
            present = self.list()
            if unknown := [name for name in values if name not in present]:
                raise UsageError(f"the kite has no parameter {unknown[0]}{closest(unknown[0], present)}")
            table = self._client.table
            changes = [Change(name, present[name], float32(value)) for name, value in values.items()
                       if present[name] != float32(value) and not (name in table and table[name].read_only)]
            self._client.write(changes)
        if refused := [change.reason for change in changes if change.state is ChangeState.REFUSED]:
            raise VehicleError("; ".join(refused))
        return changes

    def save(self, path: str | Path, style: str = "mavproxy") -> None:
        """Write all present values to a file of `style` mavproxy, missionplanner or qgroundcontrol."""
        values = self.list()
        system = self._client.connection.target.system
        write_parameter_file(path, values, (f"kitepilot, system {system}, contract {CONTRACT_HASH}",), style, system)

    def load(self, path: str | Path, rest: bool = False) -> "list[Change]":
        """Set the values that differ in the file, which may have any of these styles; see `set_all`.

        Raises:
            UsageError: the file cannot be read, or a line cannot be sent and `rest` (send the others) is not set.
        """
        file = CheckedFile(path, self._client.table)
        file.match(self.list())
        if file.problems and not rest:
            raise UsageError(f"{'; '.join(file.problems)}; nothing was set")
        return self.set_all(file.wanted)

    def diff(self, values: Mapping[str, float] | None = None) -> dict[str, tuple[float, float]]:
        """Differences between the vehicle and `values` (default: the snapshot): name to (vehicle's, other)."""
        present = self.list()
        other = self.snapshot if values is None else values
        return {name: (present[name], value) for name, value in other.items()
                if name in present and present[name] != value}

    def take_snapshot(self) -> None:
        """Make the present values those that `revert` restores."""
        self.snapshot = self.list()

    def revert(self, *names: str) -> "list[Change]":
        """Restore the snapshot, or only these parameters of it; see `set_all`."""
        chosen = [self._known(name) for name in names] or list(self.snapshot)
        return self.set_all({name: self.snapshot[name] for name in chosen if name in self.snapshot})

    def _known(self, name: str) -> str:
        table = self._client.table
        if name not in table:
            raise UsageError(f"no parameter is called {name!r}{closest(name.upper(), table)}")
        return name
