"""The truth of a flight, as it grows tick by tick."""

from typing import Any, Final

import numpy as np

from kite_analysis.figure_eight import Array
from sim_bridge.flight.truth_columns import COLUMNS, TruthRow

_WIDTH: Final = len(COLUMNS)
_ROWS: Final = 64  # of a block: few enough numbers to be in the processor's cache when they are packed


class TruthTable:
    """Rows with a value for each of COLUMNS; what has come together is packed in blocks of an array."""

    def __init__(self) -> None:
        self._blocks: list[Any] = []
        self._newest: list[float] = []  # not in a block yet
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def add(self, values: list[float]) -> None:
        """Add a row."""
        self._newest += values
        self._count += 1
        if self._count % _ROWS == 0:
            self._blocks.append(self._packed())
            self._newest = []

    def columns(self, first: int = 0) -> dict[str, Array]:
        """Columns by name, each of shape (n,), from row number `first` on."""
        blocks, within = divmod(first, _ROWS)
        values = np.concatenate([*self._blocks[blocks:], self._packed()])[within:]
        return dict(zip(COLUMNS, values.T, strict=True))

    def last(self) -> TruthRow | None:
        """The newest row, None before the first."""
        if not self._count:
            return None
        return TruthRow(**{name: float(value) for name, (value,) in self.columns(self._count - 1).items()})

    def rows(self) -> list[TruthRow]:
        """All rows."""
        return [TruthRow._make(row) for block in (*self._blocks, self._packed()) for row in block.tolist()]

    def _packed(self) -> Any:
        return np.array(self._newest, dtype=float).reshape(-1, _WIDTH)
