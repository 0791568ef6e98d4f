"""How good a least-squares fit is whose residuals are correlated in time: standard deviations, and R2."""

import numpy as np

from kite_analysis.figure_eight import Array

_LEAST_BLOCKS = 10


def blocked_std(jacobian: Array, residual: Array, block_rows: int) -> Array:
    """Standard deviations (p,) of the estimates with derivatives `jacobian` (n, p) and residuals `residual` (n,).

    The residuals of a flight are gusts and flaws of the model, correlated over seconds: a plain least-squares
    covariance would take every row for a new measurement. Here the scores are added up over blocks of `block_rows`
    rows, which are taken as independent of each other (the cluster-robust "sandwich" of Liang and Zeger, Biometrika
    73, 1986, with the correction for few clusters). Short records are cut into at least 10 blocks; what they give is
    then too small rather than too large.
    """
    rows, unknowns = jacobian.shape
    block_rows = max(1, min(block_rows, rows // _LEAST_BLOCKS))
    scale = np.sqrt(np.mean(jacobian**2, axis=0))
    scale = np.where(scale > 0.0, scale, 1.0)
    scaled = jacobian / scale
    starts = np.arange(0, rows - block_rows // 2, block_rows)
    scores = np.add.reduceat(scaled * residual[:, None], starts)
    bread = np.linalg.pinv(scaled.T @ scaled)
    blocks = len(starts)
    correction = blocks / max(1, blocks - unknowns)
    variance = correction * np.diag(bread @ (scores.T @ scores) @ bread)
    return np.sqrt(np.maximum(variance, 0.0)) / scale


def r_squared(measured: Array, residual: Array) -> float:
    """1 - the sum of squared residuals over that of the measured about their mean; NaN for a constant."""
    about_mean = float(np.sum((measured - np.mean(measured)) ** 2))
    return 1.0 - float(np.sum(residual**2)) / about_mean if about_mean > 0.0 else np.nan
