"""Figures of eight for the tests of target curve and guidance: the firmware's, and numpy's of the same shape."""

import math

import numpy as np
from hypothesis import strategies as st

from firmware_py.control.figure_eight import FigureEight
from firmware_py.control.gains import Gains
from firmware_py.estimation.turn_k_estimate import TurnKEstimate
from firmware_py.parameters.generated_parameters import DEFAULTS
from firmware_py.sphere import TangentFrame
from kite_analysis.figure_eight import TargetEight
from protocol.parameter_table import load_parameters

NAMES = list(load_parameters())


def parameters(**changed: float) -> list[float]:
    """Values of all parameters, at their default but for those `changed`."""
    assert set(changed) <= set(NAMES)
    return [changed.get(name, default) for name, default in zip(NAMES, DEFAULTS, strict=True)]


def eight(**changed: float) -> tuple[FigureEight, TargetEight]:
    """The firmware's curve and numpy's for the same parameters."""
    values = parameters(**changed)
    curve = FigureEight()
    curve.load(values)
    return curve, TargetEight.from_parameters(lambda name: values[NAMES.index(name)])


def frame_at(position) -> TangentFrame:
    """The firmware's tangent frame at a unit position (3,)."""
    x, y, z = (float(component) for component in position)
    frame = TangentFrame()
    frame.set(math.atan2(y, x), math.atan2(z, math.hypot(x, y)))
    return frame


def beside(shape: TargetEight, s: float, offset: float) -> np.ndarray:
    """Unit position (3,) at `offset` [rad] beside the curve at `s`, positive along gamma x tangent (s growing)."""
    position, tangent = shape.position(np.array([s]))[0], shape.derivatives(np.array([s]))[0][0]
    side = np.cross(position, tangent / np.linalg.norm(tangent))
    return np.cos(offset) * position + np.sin(offset) * side


@st.composite
def flyable(draw) -> dict[str, float]:
    """Parameters of an eight that a kite can fly."""
    width = draw(st.floats(15.0, 55.0))
    return {
        "EIGHT_AZIMUTH": draw(st.floats(-15.0, 15.0)), "EIGHT_HALF_W": width,
        "EIGHT_HALF_H": width * draw(st.floats(0.2, 0.4)), "EIGHT_ELEVATION": draw(st.floats(32.0, 50.0)),
        "EIGHT_DIRECTION": draw(st.sampled_from([-1.0, 1.0]))}


def gains(**changed: float) -> Gains:
    """The gains of these parameters, the others at their default, before any sample."""
    made = Gains()
    made.load(parameters(**changed), TurnKEstimate())
    return made
