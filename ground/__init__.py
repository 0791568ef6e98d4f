"""The ground station: links, the kite's state, parameters, tuning, logs, command line.

For scripts and notebooks: `ground.connect` gives a `ground.kite.Kite`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ground.errors import GroundError, NoAnswerError, UsageError, VehicleError

if TYPE_CHECKING:
    from ground.kite import Kite, connect

__all__ = ["GroundError", "Kite", "NoAnswerError", "UsageError", "VehicleError", "connect"]


def __getattr__(name: str) -> Any:
    """Import `ground.kite` when something of it is used: `kite-ground --help` needs nothing of what it imports."""
    if name not in ("Kite", "connect"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module("ground.kite"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
