"""How much one eight of a flight differs from the next.

The reel-out's first turns, in which the kite arrives, are left out: eights are counted from the second time that it
comes through the middle azimuth, each to the next time in the same direction. The climb of the centre goes out with
each eight's mean elevation. The distance is that across the path: from each of 200 points, evenly spaced along an
eight, to the nearest point of the eight before that lies within a tenth of an eight in phase.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from kite_analysis.figure_eight import Array
from kite_analysis.flights.description import FlightDataError
from kite_analysis.flights.record import FlightRecord, stretches

_POINTS = 200
_NEAR = _POINTS // 10


class EightSpread(NamedTuple):
    """The eights of one reel-out."""

    eights: int
    seconds: tuple[float, ...]  # of each eight
    climb_deg: float  # of the centre, from the first eight to the last
    rms_deg: tuple[float, ...]  # distance of each eight but the first from the one before


def eight_spread(record: FlightRecord) -> EightSpread:
    """Spread of the eights in the longest unbroken stretch of the selected rows.

    Raises:
        FlightDataError: no position, or fewer than two whole eights.
    """
    usable = record.selected & np.isfinite(record.azimuth) & np.isfinite(record.elevation)
    longest = max(stretches(usable), key=lambda part: part.stop - part.start, default=slice(0, 0))
    azimuth, elevation = record.azimuth[longest], record.elevation[longest]
    side = azimuth - np.mean(azimuth) if len(azimuth) else azimuth
    crossings = np.flatnonzero(np.diff(side >= 0.0))[1::2]
    if len(crossings) < 3:
        raise FlightDataError("fewer than two complete eights to compare")
    parts = [slice(int(start), int(stop) + 1) for start, stop in pairwise(crossings)]
    centres = [float(np.mean(elevation[part])) for part in parts]
    flat = float(np.cos(np.mean(elevation)))
    eights = [_even(np.column_stack([azimuth[part] * flat, elevation[part] - centre]))
              for part, centre in zip(parts, centres, strict=True)]
    return EightSpread(
        len(eights), tuple(float(seconds) for seconds in np.diff(crossings) * record.period_s),
        float(np.degrees(centres[-1] - centres[0])),
        tuple(float(np.degrees(np.sqrt(np.mean(_distance(new, old) ** 2))))
              for old, new in pairwise(eights)))


def _even(path: Array) -> Array:
    """Points (200, 2), evenly spaced along `path` (n, 2) [rad]."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    at = np.linspace(0.0, along[-1], _POINTS, endpoint=False)
    return np.column_stack([np.interp(at, along, path[:, 0]), np.interp(at, along, path[:, 1])])


def _distance(points: Array, path: Array) -> Array:
    """Distance [rad] of each of `points` from the segments of the closed `path` that are near it in phase."""
    index = (np.arange(_POINTS)[:, None] + np.arange(-_NEAR, _NEAR)) % _POINTS
    start = path[index]
    segment = path[(index + 1) % _POINTS] - start
    offset = points[:, None] - start
    length = np.sum(segment**2, axis=-1)
    share = np.clip(np.sum(offset * segment, axis=-1) / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
    return np.min(np.linalg.norm(offset - share[..., None] * segment, axis=-1), axis=1)
