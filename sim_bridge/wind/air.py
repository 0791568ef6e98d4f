"""The wind at one instant, as plants take it."""

from typing import NamedTuple


class Air(NamedTuple):
    """Mean wind at the reference height, and gusts as fractions of the local mean wind.

    The wind at a point is, with m the mean there (speed times the profile's factor) and d the unit vector
    (cos direction, sin direction, 0): m (gust d + across (up x d) + vertical up).
    """

    speed_m_s: float  # horizontal
    direction_rad: float = 0.0  # where it blows to, from x (downwind on average) towards y
    along: float = 0.0
    across: float = 0.0
    vertical: float = 0.0

    @property
    def gust(self) -> float:
        """1 + along, kept from turning the wind round."""
        return max(0.1, 1.0 + self.along)
