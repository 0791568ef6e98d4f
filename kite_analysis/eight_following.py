"""The target of the paper's outer loop along a flight, from the kite's true position.

J. H. Baayen, "Trajectory tracking control of kites with system delay" (2012), section 2.2.
"""

from math import pi, remainder, tau

import numpy as np

from kite_analysis.angles import wrap
from kite_analysis.figure_eight import Array, TargetEight, turning_angle

_JUMP_RAD = 0.5 * pi  # in s: further apart than what two ticks have between them
_COURSE_WEIGHT = 0.2  # of flying the right way, beside being near, for the strand that a flight begins on
_MUCH_NEARER = 0.7


def follow_eight(eight: TargetEight, position: Array, course: Array, gain_l: Array | float) -> tuple[Array, Array]:
    """Target turning angle and cross-track distance [rad], each (n,), of a kite at successive unit positions (n, 3).

    `gain_l` is the outer loop's gain L. Where the strands of the eight cross, the kite stays on the one that it came
    along, as the firmware does; the distance is that to the nearest point of either.
    """
    strands, distances = eight.nearest_of_strands(position)
    first = _best(eight, position[0], float(course[0]), strands[:, 0], distances[:, 0])
    followed = _stay(strands, distances, first, eight.half_width)
    index = np.arange(len(followed))
    return aim(eight, position, strands[followed, index], gain_l), np.min(distances, axis=0)


def aim(eight: TargetEight, position: Array, s: Array, gain_l: Array | float) -> Array:
    """Target turning angle [rad] (n,) at unit positions (n, 3): T + L (t . gamma_t) t, with gamma_t the curve at s."""
    along, side = carried_tangent(eight, position, s)
    return wrap(along + np.arctan(gain_l * side))


def carried_tangent(eight: TargetEight, position: Array, s: Array) -> tuple[Array, Array]:
    """Turning angle of the curve's tangent at `s`, carried to the kite along the geodesic, and t . gamma_t."""
    point = eight.position(s)
    tangent = eight.direction * eight.derivatives(s)[0]
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    cosine = np.sum(position * point, axis=-1)
    carry = np.sum(position * tangent, axis=-1) / (1.0 + np.maximum(cosine, -0.999))
    carried = tangent - carry[:, None] * (position + point)
    return turning_angle(position, carried), np.sum(np.cross(position, carried) * point, axis=-1)


def _best(eight: TargetEight, position: Array, course: float, strands: Array, distances: Array) -> int:
    """The strand that suits a kite's place and course best."""
    along, _ = carried_tangent(eight, np.stack([position, position]), strands)
    return int(np.argmax(np.cos(distances) + _COURSE_WEIGHT * np.cos(along - course)))


def _stay(strands: Array, distances: Array, first: int, half_width: float) -> list[int]:
    """Which strand is followed at each place: the nearer one, unless that is a leap along the curve."""
    followed, s = [], float(strands[first, 0])
    for places, (one, other) in zip(strands.T.tolist(), distances.T.tolist(), strict=True):
        near = 0 if one <= other else 1
        far = 1 - near
        nearest, next_nearest = (one, other) if near == 0 else (other, one)
        strand = near
        if _leaps(s, places[near]):
            lost = next_nearest > half_width and nearest < _MUCH_NEARER * next_nearest
            if not lost and not _leaps(s, places[far]):
                strand = far
        followed.append(strand)
        s = places[strand]
    return followed


def _leaps(s: float, to: float) -> bool:
    return abs(remainder(to - s, tau)) > _JUMP_RAD
