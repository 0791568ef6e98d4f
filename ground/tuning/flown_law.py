"""The control law in use, and what it allows: the limit of P, the best P for settling, and for following the eight.

The theory is in kite_analysis/delay/flown_loop.py, and in docs/delay.md in words.
"""

import math
from typing import Any, NamedTuple

from ground.session import Session
from ground.tuning.gain_advice import GAIN_NAME, OUTER_NAME, GainAdvice
from ground.tuning.in_flight import Effect
from kite_analysis.delay.characteristic_roots import Gains
from kite_analysis.delay.flown_loop import FlownLoop, flown_limit, following_error
from kite_analysis.figure_eight import TargetEight
from protocol.single_precision import float32

_SETTINGS = ("PRED_DELAY", "FF_GAIN", "FF_FILTER", "GAIN_TAU")
_EIGHT = ("EIGHT_AZIMUTH", "EIGHT_ELEVATION", "EIGHT_HALF_W", "EIGHT_HALF_H", "EIGHT_DIRECTION")
WRONG_DELAY = 0.25  # relative error of the predicted delay to allow for
_TICK_S = 0.02  # for which a sample may wait, if the firmware runs on its own clock
_MARGIN = 2.0  # gain margin of P
_WORTH = 0.85  # of the error: a smaller improvement is within the variation of a flight
_LIKELY = (0.3, 2.0)  # measured over computed error: outside, something else causes the error
_FLIES_RAD = math.radians(60.0)  # turning-angle error, RMS, of a kite that still follows its eight
_LEAST_SHARE, _TRIED = 0.1, 60


class FlownLaw(NamedTuple):
    """The control law, from the vehicle's parameters; `eight` is None unless in TRACK."""

    predicted_s: float
    feed_forward: float
    filter_s: float
    scheduled: bool
    eight: TargetEight | None

    @property
    def name(self) -> str:
        """The law in words."""
        fed = f"target rate fed forward (FF_GAIN {self.feed_forward:.3g})" if self.feed_forward else ""
        if self.predicted_s:
            return f"prediction over PRED_DELAY = {self.predicted_s:.4g} s" + (f", {fed}" if fed else "")
        return f"plain law with {fed}" if fed else "plain law: no prediction, no feed-forward"


class FlownAdvice(NamedTuple):
    """P [1/s] for the law in use; None where unknown. Errors are cross-track, RMS [rad].

    `limit`: of P; `wrong_limit`: the lower of its values with a delay 25 % shorter or longer than predicted. `settling`
    and `following`: the best P for each; `following_rad` and `present_rad`: the computed errors on the eight at the
    best P and at the present one; `measured_rad`: the error in flight. `proposal`: the P to set, or None; `reason` says
    why in either case. `urgent`: the flight is diverging.
    """

    law: FlownLaw
    limit: float
    wrong_limit: float | None
    settling: float
    following: float | None
    following_rad: float | None
    present_rad: float | None
    measured_rad: float | None
    verdict: str
    proposal: float | None
    reason: str
    urgent: bool = False


def read_law(session: Session) -> FlownLaw:
    """Read the law from the vehicle's parameters. Raises VehicleError as `ParameterClient.fetch`."""
    values = {name: session.parameters.fetch(name) for name in _SETTINGS}
    eight = None
    if session.state.mode_name == "TRACK":
        shape = {name: session.parameters.fetch(name) for name in _EIGHT}
        eight = TargetEight.from_parameters(shape.__getitem__)
    return FlownLaw(values["PRED_DELAY"], values["FF_GAIN"], values["FF_FILTER"], values["GAIN_TAU"] > 0.0, eight)


def advise_on(law: FlownLaw, advice: GainAdvice, speed: float | None, outer_l: float,
              flown: Effect | None) -> FlownAdvice:
    """Advice for `law` with the delay and P of `advice`, at `speed` over line length [1/s], if known.

    `flown` are the errors just measured in flight.
    """
    if law.predicted_s:
        return _decided(_with_prediction(law, advice, speed, outer_l, flown), advice, flown)
    return _decided(_without_prediction(law, advice, speed, outer_l, flown), advice, flown)


def _without_prediction(law: FlownLaw, advice: GainAdvice, speed: float | None, outer_l: float,
                        flown: Effect | None) -> FlownAdvice:
    nothing = FlownAdvice(law, advice.sampled_limit, None, advice.optimum, None, None, None, _cross_track(flown), "",
                          None, "")
    if not speed:
        return nothing
    loop = FlownLoop(advice.delay_s, advice.loop_hz, speed, law.feed_forward, law.filter_s)
    limit = flown_limit(loop, outer_l)
    following = following_rad = present_rad = None
    if law.eight and limit > 0.0:
        errors = {gain: following_error(loop, Gains(gain, outer_l), law.eight)
                  for gain in [limit / _MARGIN * (_LEAST_SHARE + (1.0 - _LEAST_SHARE) * step / (_TRIED - 1))
                               for step in range(_TRIED)]}
        following = min(errors, key=errors.__getitem__)
        following_rad = errors[following]
        if advice.present < limit:
            present_rad = following_error(loop, Gains(advice.present, outer_l), law.eight)
    return nothing._replace(limit=limit, following=following, following_rad=following_rad, present_rad=present_rad)


def _with_prediction(law: FlownLaw, advice: GainAdvice, speed: float | None, outer_l: float,
                     flown: Effect | None) -> FlownAdvice:
    """A perfect prediction removes the delay from the loop; the gains must allow for a delay that is 25 % off."""
    tau_s = law.predicted_s
    best = 1.0 / (math.e * (WRONG_DELAY * tau_s + 0.5 / advice.loop_hz))
    limit, wrong = advice.loop_hz, None
    if speed:
        right, *others = (flown_limit(FlownLoop(true_s, advice.loop_hz, speed, law.feed_forward, 0.0, tau_s), outer_l)
                          for true_s in (tau_s, tau_s * (1.0 - WRONG_DELAY), tau_s * (1.0 + WRONG_DELAY)))
        limit, wrong = right, min(others)
        best = min(best, wrong / _MARGIN) if wrong else best
    return FlownAdvice(law, limit, wrong, best, best if law.eight else None, None, None, _cross_track(flown), "", None,
                       "")


def _decided(found: FlownAdvice, advice: GainAdvice, flown: Effect | None) -> FlownAdvice:
    """Add verdict, proposal and reason. Measured errors take precedence over computed ones."""
    law, present = found.law, advice.present
    on_the_eight = flown is not None and law.eight is not None and flown.turning_rad < _FLIES_RAD
    beyond = present >= found.limit or present >= (found.wrong_limit or math.inf)
    verdict = _verdict(found, present, on_the_eight)
    found = found._replace(verdict=verdict)
    if law.scheduled:
        return found._replace(reason=f"GAIN_TAU is set, so the gain schedule gives P and {GAIN_NAME} is not used: "
                                     "change GAIN_P_TAU, or set GAIN_TAU to 0")
    if beyond and not on_the_eight:
        return found._replace(proposal=float32(found.settling), urgent=law.eight is not None and present >= found.limit,
                              reason="the present gain is unstable; with this one the kite settles, then run tune "
                                     "again")
    if law.predicted_s:
        return _for_the_prediction(found, present, beyond)
    if law.eight is None or found.limit == advice.sampled_limit:
        same = float32(found.settling) == present
        return found._replace(proposal=None if same else float32(found.settling), reason="1 / (e tau) settles fastest")
    return _for_the_eight(found, present)


def _for_the_prediction(found: FlownAdvice, present: float, beyond: bool) -> FlownAdvice:
    if beyond:
        return found._replace(reason="it flies well, but would not if the delay were 25 % off: "
                                     f"{found.settling:.3g} leaves room for that")
    if present < 0.8 * found.settling:
        return found._replace(proposal=float32(found.settling),
                              reason="it is stable even if the predicted delay is 25 % off")
    return found._replace(reason="the present gain suits the prediction")


def _for_the_eight(found: FlownAdvice, present: float) -> FlownAdvice:
    best, best_rad, present_rad = found.following, found.following_rad, found.present_rad
    if best is None or best_rad is None or present_rad is None:
        return found._replace(reason=f"no P is stable with this {OUTER_NAME}: lower {OUTER_NAME} first")
    if found.measured_rad is not None and not _LIKELY[0] < found.measured_rad / present_rad < _LIKELY[1]:
        return found._replace(reason=f"gains alone explain {math.degrees(present_rad):.2g} deg of cross-track "
                                     "error: gusts, saturation or a wrong TURN_K cause the rest; --step tries a gain")
    if best_rad > _WORTH * present_rad:
        near = f"the present gain has a margin of {found.limit / present:.2g}" if present > best else ""
        return found._replace(reason="no P with a gain margin of 2 follows the eight better"
                              + (f"; {near}" if near else ""))
    measured = "" if found.measured_rad is None else (
        f", about {math.degrees(found.measured_rad * best_rad / present_rad):.2g} deg of cross-track error instead of "
        f"{math.degrees(found.measured_rad):.2g}")
    return found._replace(proposal=float32(best), reason=f"it follows the eight better{measured}")


def _verdict(found: FlownAdvice, present: float, on_the_eight: bool) -> str:
    if present <= 0.0:
        return "no steering: P is 0"
    if present >= found.limit:
        if on_the_eight:
            return "above the computed limit, yet stable in flight: the delay or TURN_K assumed here is wrong"
        return "UNSTABLE: above the limit"
    if found.wrong_limit and present >= found.wrong_limit:
        return "stable if PRED_DELAY is right; UNSTABLE if it is 25 % off"
    if present > found.limit / 1.5:
        return f"stable, but the gain margin is only {found.limit / present:.2g}"
    return "stable"


def _cross_track(flown: Effect | None) -> float | None:
    return None if flown is None or math.isnan(flown.cross_track_rad) else flown.cross_track_rad


def describe_flown(found: FlownAdvice, advice: GainAdvice) -> list[str]:
    """The law in use and its gains, as lines."""
    law = found.law
    lines = [f"flown: {law.name}", f"       {'follows the eight' if law.eight else 'settles (not in TRACK)'}"]
    if law.predicted_s:
        lines.append(_prediction_line(law, advice.delay_s))
    lines.append(f"{'limit of P, present control law':<36}{found.limit:>10.4g}"
                 + ("" if found.wrong_limit is None else f"   {found.wrong_limit:.4g} if the delay is 25 % off"))
    lines.append(f"{'best P for settling':<36}{found.settling:>10.4g}")
    if found.following is not None:
        error = "" if found.following_rad is None else f"   {math.degrees(found.following_rad):.2g} deg by theory"
        lines.append(f"{'best P for following the eight':<36}{found.following:>10.4g}{error}")
    if found.measured_rad is not None and law.eight:
        by = "" if found.present_rad is None else f"   {math.degrees(found.present_rad):.2g} deg by theory"
        lines.append(f"{'cross-track error in flight, RMS':<36}{math.degrees(found.measured_rad):>6.2f} deg{by}")
    return lines


def _prediction_line(law: FlownLaw, delay_s: float) -> str:
    if abs(delay_s - law.predicted_s) > WRONG_DELAY * law.predicted_s + _TICK_S:
        return f"       tau = {delay_s:.4g} s differs from PRED_DELAY: run kite-ground tune --identify"
    return "       the delay is predicted, so the paper's limit below does not apply"


def flown_as_dictionary(found: FlownAdvice) -> dict[str, Any]:
    """The advice as a dictionary, for scripts."""
    law = found.law._asdict()
    eight = law.pop("eight")
    return {**found._asdict(), "law": {**law, "name": found.law.name, "follows_the_eight": eight is not None}}
