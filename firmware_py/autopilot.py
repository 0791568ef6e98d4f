"""One tick of the control loop: sample -> estimate -> outer loop -> inner loop -> actuator -> link."""

from .clock import MASK
from .control.figure_eight import FigureEight
from .control.gains import Gains
from .control.guidance import Guidance
from .control.mode_laws import steer_by_mode
from .control.steering import Steering
from .estimation.estimator import Estimator
from .estimation.turn_k_estimate import TurnKEstimate
from .generated_enums import (
    HIL_ACTUATOR_CONTROLS_FLAGS_LOCKSTEP,
    KITE_MODE_PARK,
    KITE_MODE_TRACK,
)
from .mavlink.generated_messages import HIL_ACTUATOR_CONTROLS
from .modes.mode_machine import ModeMachine
from .parameters.generated_parameters import LOOP_HZ, SYSTEM_ID
from .parameters.persistence import Keeper
from .parameters.values import Parameters
from .prediction.prediction import Prediction
from .prediction.steering_history import ROOM, SteeringHistory
from .services.dispatcher import Dispatcher
from .services.inbox import Inbox
from .services.telemetry import Telemetry
from .sphere import wrap
from .timing import Timing

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

    from .boards.interface import Retained, Storage
    from .control.interface import Kite, OuterLoop
    from .mavlink.interface import Link

_UPTIME = 0  # type: Final  # places in HIL_ACTUATOR_CONTROLS
_STEERING = 2  # type: Final
_STEERED = (KITE_MODE_PARK, KITE_MODE_TRACK)  # type: Final[tuple[int, ...]]  # by the control laws


class Autopilot:
    """Everything that flies the kite, over one `link`.

    The link has `send(message, values)`, `receive(inbox)`, `flush()`, `set_system(id)`, `counters()` and `budget`.
    Another outer loop can replace `guidance`: it needs all that Guidance has except its settings.
    `storage`, `retained` and `reset_cause` are the board's (boards/interface.py); without them nothing is stored.
    """

    def __init__(
        self, link: "Link", lockstep: bool = False, storage: "Storage | None" = None,
        retained: "Retained | None" = None, reset_cause: str | None = None
    ) -> None:
        self.link = link
        self.inbox = Inbox()
        self.parameters = Parameters()
        self.curve = FigureEight()
        self.kite = Estimator()
        self.guidance: "OuterLoop" = Guidance(self.curve)
        self.steering = Steering()
        self.history = SteeringHistory()
        self.prediction = Prediction(self.history)
        self.gains = Gains()
        self.turn_k = TurnKEstimate()
        self.timing = Timing()
        self.telemetry = Telemetry(link, self)
        self.modes = ModeMachine(self.parameters, self.kite, self.telemetry.say)
        self.keeper = Keeper(self.parameters, self.modes, storage, retained, self.telemetry.say)
        self.dispatcher = Dispatcher(
            self.parameters, self.modes, self.kite, self.turn_k, self.keeper, link, self.telemetry, self.timing
        )
        self.target_course: float = 0.0
        self.period_us: int = 20000
        flags = HIL_ACTUATOR_CONTROLS_FLAGS_LOCKSTEP if lockstep else 0
        # Kept: a board looks long for the place of a new one.
        self._controls: list[int | float] = [0, flags] + [0.0] * 16 + [0]
        self._uptime_us: int = 0  # does not wrap
        self._last_tick: int | None = None
        self._elapsed_us: int = 0  # between the last two ticks
        self._behind_us: int = 0  # of the loop's beat: time that is not in the steering's history yet
        self._loaded: int = -1
        self.keeper.start(reset_cause)

    def tick(self, now: int) -> None:
        """Run the loop once at `now` [us, wrapped]. The link has put what arrived into `inbox` before."""
        self.steer(now, 0)
        self.serve(now)

    def steer(self, now: int, late_us: int) -> None:
        """The first half of a tick, that begins `late_us` after it was due: from the newest sample to the steering.

        The steering is left with the link.
        """
        last_tick = self._last_tick
        elapsed_us = 0 if last_tick is None else (now - last_tick) & MASK
        self._last_tick = now
        self._elapsed_us = elapsed_us
        uptime_us = self._uptime_us = self._uptime_us + elapsed_us
        link = self.link
        link.budget.refill(elapsed_us)
        if self._loaded != self.parameters.version:
            self._load_parameters()
        kite = self.kite
        steering = self.steering
        missing = kite.wait(elapsed_us)  # a gap that ends in this tick was one all the same
        sample = self.inbox.take_sample()
        fresh = sample is not None and kite.take(sample, steering.asked, self.gains.turn_k)
        self.modes.update(elapsed_us, missing, fresh)
        due = now - late_us
        if fresh:
            self._learn(due)
        self._steer(fresh, due, late_us)
        self.history.note(steering.asked, self._whole_ticks(elapsed_us))
        controls = self._controls
        controls[_UPTIME] = uptime_us
        controls[_STEERING] = steering.asked
        link.send(HIL_ACTUATOR_CONTROLS, controls)

    def serve(self, now: int) -> None:
        """The second half: what was asked, what is to be kept, and what is told."""
        self.dispatcher.serve(self.inbox, now, self._uptime_us)
        self.keeper.update(self._elapsed_us, self._uptime_us)  # before the flush: what is acknowledged is kept
        self.telemetry.send_due(now, self._uptime_us)
        self.link.flush()

    def _whole_ticks(self, elapsed_us: int) -> int:
        """Periods that went by with this tick, 1 at least; what is left of a period counts with the next."""
        period_us = self.period_us
        behind_us = self._behind_us + elapsed_us - period_us
        ticks = 1
        if behind_us >= period_us - period_us // 2:
            if behind_us > period_us * (ROOM - 1):
                behind_us = period_us * (ROOM - 1)
            ticks += (behind_us + period_us // 2) // period_us
            behind_us -= (ticks - 1) * period_us
        self._behind_us = behind_us if behind_us > -period_us else -period_us
        return ticks

    def _load_parameters(self) -> None:
        """Take all settings over at once, between two ticks."""
        values = self.parameters.values
        self.curve.load(values)
        self.kite.config.load(values)
        self.guidance.config.load(values)
        self.steering.config.load(values)
        self.prediction.config.load(values)
        self.history.load(values)
        self.turn_k.load(values)
        self.gains.load(values, self.turn_k)
        self.period_us = int(1000000 / values[LOOP_HZ])
        self.link.set_system(int(values[SYSTEM_ID]))
        self._loaded = self.parameters.version

    def _learn(self, now: int) -> None:
        """Let what adapts in flight see a new sample, in the tick that was due at `now`."""
        kite = self.kite
        prediction = self.prediction
        turn_k = self.turn_k
        prediction.note_sample(kite, now)
        turn_k.take(kite, prediction.steering_at_sample(kite, now))
        self.gains.update(kite, turn_k)

    def _steer(self, fresh: bool, now: int, late_us: int) -> None:
        """Let the mode's law steer, in the tick that was due at `now`."""
        estimate = self.kite
        kite: "Kite" = estimate
        modes = self.modes
        guidance = self.guidance
        prediction = self.prediction
        gains = self.gains
        mode = modes.mode
        predicted = prediction.config.delay_us and not modes.stale and mode in _STEERED
        if predicted:
            kite = prediction
            prediction.update(estimate, now, gains.turn_k, late_us)
        if fresh:
            guidance.scan(estimate.frame, estimate.course)
        if mode != KITE_MODE_TRACK or modes.stale:
            guidance.stop()
        elif predicted:
            guidance.step_exactly(prediction, gains)
        elif fresh or not guidance.running:
            guidance.step(estimate.frame, gains, estimate.interval)
        target_course = steer_by_mode(modes, guidance, self.steering, kite, gains, self.period_us * 1e-6)
        if predicted:  # what is told goes with the sample: the error is the one that was steered by
            target_course = wrap(estimate.course + self.steering.error)
        self.target_course = target_course
