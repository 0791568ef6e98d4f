"""The ground station: links, the kite's state, parameters, tuning, logs, command line.

For scripts and notebooks: `ground.connect` gives a `ground.kite.Kite`.
"""

from ground.errors import GroundError, NoAnswerError, UsageError, VehicleError
from ground.kite import Kite, connect

__all__ = ["GroundError", "Kite", "NoAnswerError", "UsageError", "VehicleError", "connect"]
