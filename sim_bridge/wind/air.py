"""The wind at one instant, as plants take it."""


class Air:
    """Mean wind at the reference height, and gusts as fractions of the local mean wind.

    The wind at a point is, with m the mean there (speed times the profile's factor) and d the unit vector
    (cos direction, sin direction, 0): m (gust d + across (up x d) + vertical up).

    `speed_m_s` is horizontal; `direction_rad` is where it blows to, from x (downwind on average) towards y. `gust` is
    1 + `along`, kept from turning the wind round.
    """

    def __init__(self, speed_m_s: float, direction_rad: float = 0.0, along: float = 0.0, across: float = 0.0,
                 vertical: float = 0.0) -> None:
        self.speed_m_s = speed_m_s
        self.direction_rad = direction_rad
        self.along = along
        self.gust = max(0.1, 1.0 + along)
        self.across = across
        self.vertical = vertical
