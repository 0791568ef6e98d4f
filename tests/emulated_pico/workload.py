"""Runs on the board: points on a cubic B-spline in space, as objects, lists and floats make them. Prints microseconds.

Much like what MicroPython's own benchmark bm_chaos does, so that the two are slow for the same reasons.
"""

import gc
import time


class Point:
    """A point in space."""

    def __init__(self, x, y, z):
        self.x = x
        self.y = y
        self.z = z

    def between(self, other, weight):
        """The point that divides the way to `other` at `weight` of it."""
        rest = 1.0 - weight
        return Point(
            self.x * rest + other.x * weight, self.y * rest + other.y * weight, self.z * rest + other.z * weight)

    def __sub__(self, other):
        return Point(self.x - other.x, self.y - other.y, self.z - other.z)


class Curve:
    """A uniform cubic B-spline over control points, by the recursion of de Boor."""

    def __init__(self, points):
        self.points = points

    def at(self, place):
        """The point at `place`, from 0 to the number of segments."""
        segment = min(int(place), len(self.points) - 4)
        within = place - segment
        left = [self.points[segment + index] for index in range(4)]
        for level in range(1, 4):
            for index in range(3, level - 1, -1):
                weight = (within + 3 - index) / (4 - level)
                left[index] = left[index - 1].between(left[index], weight)
        return left[3]


def work(steps):
    """Walk along a curve that closes, and add up how far it is."""
    corners = ((1.0, 0.0), (0.3, 0.9), (-0.8, 0.6), (-0.8, -0.6), (0.3, -0.9))
    points = [Point(x, y, 0.1 * index) for index, (x, y) in enumerate(corners * 2)]
    curve = Curve(points)
    length = 0.0
    last = curve.at(0.0)
    for step in range(1, steps + 1):
        here = curve.at(5.0 * step / steps)
        way = here - last
        length += (way.x**2 + way.y**2 + way.z**2) ** 0.5
        last = here
    return length


gc.collect()
start = time.ticks_us()  # type: ignore[attr-defined]
distance = work(60)
print("took", time.ticks_diff(time.ticks_us(), start), "us for", round(distance, 2))  # type: ignore[attr-defined]
