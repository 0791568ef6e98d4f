"""An operator at the keyboard: runs kite-ground's command lines against a simulated kite."""

import argparse

import pytest

from ground.cli.main import build_parser
from ground.cli.options import DEFAULTS
from ground.cli.terminal import tell
from ground.errors import GroundError
from ground.session import Session


class Operator:
    """Runs command lines; `said` is what the last one printed, `remarked` what it wrote on stderr."""

    def __init__(self, kite, capsys) -> None:
        self.kite = kite
        self.defaults = {**DEFAULTS, "wall_clock": kite.wall_clock}
        self._capsys = capsys
        self.said = ""
        self.remarked = ""

    def connect(self) -> Session:
        return self.kite.session(tell)

    def runs(self, *arguments: object) -> int:
        args = build_parser().parse_args([str(word) for word in arguments], argparse.Namespace(**self.defaults))
        try:
            return args.run(args, self.connect)
        finally:
            self.said, self.remarked = self._capsys.readouterr()

    def is_told(self, kind: type[GroundError], said: str, *arguments: object) -> None:
        with pytest.raises(kind, match=said):
            self.runs(*arguments)
