"""What the control laws need of each other and of the kite, for the types alone: no board has this file."""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Protocol, TypeAlias

    from ..estimation.estimator import Estimator
    from ..prediction.prediction import Prediction
    from ..sphere import TangentFrame
    from .gains import Gains

    Kite: TypeAlias = Estimator | Prediction  # what is steered: the kite as it was at the sample, or as it will be

    class Config(Protocol):
        """Settings that come from the parameters."""

        def load(self, values: list[float]) -> None:
            """Load the settings from the parameters' `values`."""
            ...

    class OuterLoop(Protocol):
        """What says where to fly to: Guidance, or another in its place. Angles in radians."""

        running: bool  # True while a strand is followed
        path_parameter: float
        target_course: float
        target_rate: float  # [rad/s]
        cross_track: float

        @property
        def config(self) -> Config:
            """Its settings."""
            ...

        def stop(self) -> None:
            """Forget the strand: the next step picks the best one anew."""
            ...

        def scan(self, frame: TangentFrame, course: float) -> None:
            """A new sample was taken: look around."""
            ...

        def step(self, frame: TangentFrame, gains: Gains, dt: float) -> None:
            """Update the target for the kite at `frame`, `dt` [s] after the step before."""
            ...

        def step_exactly(self, kite: Prediction, gains: Gains) -> None:
            """Update the target for a predicted kite, each tick."""
            ...
