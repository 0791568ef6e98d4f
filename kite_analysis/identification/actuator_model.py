"""A steering actuator with a dead time, a rate limit and a saturation, run over recorded steering.

Many runs go side by side, from different starts or with different settings: one numpy operation moves all of them.
"""

from typing import NamedTuple

import numpy as np

from kite_analysis.figure_eight import Array

_NO_LIMIT = 1e12  # [1/s], and finite


class ActuatorModel(NamedTuple):
    """Settings; each a number, or an array that broadcasts against the starts. Infinite: there is no such limit."""

    dead_time_s: float | Array
    rate_limit_per_s: float | Array = np.inf
    saturation: float | Array = np.inf


def follow(model: ActuatorModel, commanded: Array, period_s: float, starts: Array, first: Array, rows: int) -> Array:
    """Positions (rows + 1, ...) from the rows `starts` on, where they are `first`.

    `commanded` steering (n,) applies from each row to the next, so that within a row's time the value that is felt
    changes once, at the dead time's fraction of the period: both parts are exact. Before the record, it is that of the
    first row.
    """
    delay = np.asarray(model.dead_time_s) / period_s
    whole = np.floor(delay + 1e-9).astype(int)
    share = np.maximum(delay - whole, 0.0)
    shape = np.broadcast_shapes(starts.shape, first.shape, *(np.shape(value) for value in model))
    step = np.broadcast_to(np.minimum(model.rate_limit_per_s, _NO_LIMIT) * period_s, shape)
    early, late = step * share, step * (1.0 - share)
    split = bool(np.any(share > 0.0))
    position = np.empty((rows + 1, *shape))
    here = position[0] = first
    old = None
    for row in range(rows + 1):
        index = np.minimum(np.maximum(starts + (row - 1) - whole, 0), len(commanded) - 1)
        new = np.minimum(np.maximum(commanded[index], -model.saturation), model.saturation)
        if old is not None:
            if split:  # the value of the row before is felt for a while yet; for no time at all where share is 0
                here = here + np.minimum(np.maximum(np.where(share > 0.0, old - here, 0.0), -early), early)
            here = here + np.minimum(np.maximum(new - here, -late), late)
            position[row] = here
        old = new
    return position
