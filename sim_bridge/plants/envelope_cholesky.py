"""Cholesky factorization of the matrix of coupled points, three rows each, and solution with it.

What is left of the first block of each row stays empty in the factor, too, and is never looked at: that is the matrix's
envelope, `starts` (n,), for each point the first one that it is coupled to. Of the matrix (3 n, 3 n) only the lower
triangle is used.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from sim_bridge.compiled import compiled


def envelope(count: int, ends: NDArray[np.int64]) -> NDArray[np.int64]:
    """The envelope `starts` of `count` points, coupled in the pairs `ends` (m, 2), where negative ones are none."""
    starts = np.arange(count)
    for first, second in ends:
        low, high = min(first, second), max(first, second)
        if low >= 0:
            starts[high] = min(starts[high], low)
    return starts


@compiled
def factor(matrix, starts):
    """Cholesky factor in the lower triangle of `matrix`, within its envelope, but with the diagonal's reciprocals."""
    for row in range(len(matrix)):
        first = 3 * starts[row // 3]
        for column in range(first, row + 1):
            value = matrix[row, column]
            for k in range(max(first, 3 * starts[column // 3]), column):
                value -= matrix[row, k] * matrix[column, k]
            matrix[row, column] = 1.0 / sqrt(value) if row == column else value * matrix[column, column]


@compiled
def solve(matrix, starts, vector):
    """Solve in place with the factor from `factor`; `vector` is (n, 3)."""
    flat = vector.reshape(vector.size)
    for row in range(len(flat)):
        value = flat[row]
        for k in range(3 * starts[row // 3], row):
            value -= matrix[row, k] * flat[k]
        flat[row] = value * matrix[row, row]
    for row in range(len(flat) - 1, -1, -1):
        value = flat[row] * matrix[row, row]
        flat[row] = value
        for k in range(3 * starts[row // 3], row):
            flat[k] -= matrix[row, k] * value
