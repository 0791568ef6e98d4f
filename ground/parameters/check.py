"""Checks a parameter file before anything is sent."""

from collections.abc import Collection
from pathlib import Path

from ground.parameters.file import scan_parameter_file
from kite_analysis.console.mistakes import closest
from protocol.parameter_table import Parameter

Values = dict[str, float]


class CheckedFile:
    """A parameter file, checked against the table. `wanted` are the values that the table allows.

    Raises:
        ParameterFileError: the file cannot be read.
    """

    def __init__(self, path: str | Path, table: dict[str, Parameter]) -> None:
        self.path = path
        contents = scan_parameter_file(path)
        self.wanted: Values = {}
        self._problems = list(contents.problems)
        self._lines = {name: entry.line for name, entry in contents.entries.items()}
        for name, entry in contents.entries.items():
            parameter = table.get(name)
            problem = parameter.problem_with(entry.value) if parameter and not parameter.read_only else None
            if problem:
                self._problems.append((entry.line, problem))
            else:
                self.wanted[name] = entry.value

    @property
    def problems(self) -> list[str]:
        """A message for each line of the file that cannot be sent, in the file's order."""
        return [f"{self.path}:{line}: {problem}" for line, problem in sorted(self._problems)]

    def match(self, known: Collection[str], unknown: str = "the kite has no parameter") -> None:
        """Report names that are not `known` as problems too, each in the words `unknown` NAME."""
        for name in [name for name in self.wanted if name not in known]:
            self._problems.append((self._lines[name], f"{unknown} {name}{closest(name, known)}"))
            del self.wanted[name]
