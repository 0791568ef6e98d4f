"""What of a parameter file can be sent, and a line for each thing that cannot."""

from pathlib import Path

from analysis.closest import closest
from ground.parameter_file import scan_parameter_file
from protocol.parameter_table import Parameter

Values = dict[str, float]


class CheckedFile:
    """A parameter file against the table. `wanted` can be sent as far as the table knows; `problems` cannot.

    Raises:
        ParameterFileError: the file cannot be read at all.
    """

    def __init__(self, path: str | Path, table: dict[str, Parameter]) -> None:
        self.path = path
        contents = scan_parameter_file(path)
        self.wanted: Values = {}
        self.problems = list(contents.problems)
        self._lines = {name: entry.line for name, entry in contents.entries.items()}
        for name, entry in contents.entries.items():
            parameter = table.get(name)
            problem = parameter.problem_with(entry.value) if parameter and not parameter.read_only else None
            if problem:
                self.problems.append(f"{path}:{entry.line}: {problem}")
            else:
                self.wanted[name] = entry.value

    def match(self, present: Values) -> None:
        """Hold the file against what the vehicle has: a name that it does not know is a problem too."""
        for name in [name for name in self.wanted if name not in present]:
            self.problems.append(f"{self.path}:{self._lines[name]}: the vehicle has no parameter {name}"
                                 f"{closest(name, present)}")
            del self.wanted[name]
