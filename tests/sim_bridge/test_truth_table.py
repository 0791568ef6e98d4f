"""The truth of a flight as it grows: all of it, the end of it, and its newest row."""

import numpy as np
import pytest

from sim_bridge.flight.truth_columns import COLUMNS, TruthRow
from sim_bridge.flight.truth_table import TruthTable


@pytest.mark.parametrize("count", [1, 63, 64, 65, 128, 200])
def test_the_end_of_a_table_is_that_of_its_rows_whatever_has_been_packed(count):
    table = TruthTable()
    assert table.last() is None
    for row in range(count):
        table.add([row + 0.01 * column for column in range(len(COLUMNS))])
        assert table.last() == TruthRow._make([row + 0.01 * column for column in range(len(COLUMNS))])
    rows = table.rows()
    assert len(table) == len(rows) == count
    whole = table.columns()
    for first in {0, count // 2, max(0, count - 65), count - 1}:
        for name, values in table.columns(first).items():
            assert np.array_equal(values, whole[name][first:])
            assert values.tolist() == [getattr(row, name) for row in rows[first:]]
