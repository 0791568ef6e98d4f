"""Where ground stations are."""

from dataclasses import dataclass

from sim_bridge.settings import Settings, words


@dataclass(frozen=True, kw_only=True)
class GroundSettings(Settings):
    """The scenario's section `ground`: where ground stations are."""

    send_to: str = words("127.0.0.1:14550", "address that the kite sends to")
    listen: str = words("127.0.0.1:14551", "address that the kite listens on; port 0 is any free one")
