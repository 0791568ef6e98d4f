"""The law on real flights: identified, tested on the other half, used for prediction and in simulation."""

import math
from collections.abc import Sequence

from kite_analysis.console.tables import table, with_std
from kite_analysis.flights.record import FlightRecord
from kite_analysis.identification.actuator_fit import identify_actuator
from kite_analysis.identification.eight_spread import eight_spread
from kite_analysis.identification.heading_prediction import cross_predictions
from kite_analysis.identification.turning_rate_fit import identify_law, score
from sim_bridge.runs.run import RunOptions, run_scenario
from sim_bridge.scenario.scenario import Scenario, load_scenario

_LIMITS_DEG = {("actual", 2.0): 5.5, ("actual", 5.0): 11.0, ("commanded", 2.0): 7.0, ("commanded", 5.0): 13.0}
_TURBULENCE = 0.15


def law_table(names: Sequence[str], records: Sequence[FlightRecord]) -> str:
    """K, gravity, offset, lag and R2 of each flight, and the fit of one half's law on the other half."""
    rows = []
    for name, record in zip(names, records, strict=True):
        fit = identify_law(record)
        used = record.time_s[record.selected]
        middle = 0.5 * float(used[0] + used[-1])
        halves = [record.between(0.0, middle), record.between(middle, math.inf)]
        fits = [identify_law(half) for half in halves]
        apart = max(abs(fits[0].k_rad_per_m / fits[1].k_rad_per_m - 1.0),
                    abs(fits[1].k_rad_per_m / fits[0].k_rad_per_m - 1.0))
        lost = max(fits[1].r2 - score(halves[1], fits[0]), fits[0].r2 - score(halves[0], fits[1]))
        rows.append([
            name, with_std(fit.k_rad_per_m, fit.k_rad_per_m_std, 3),
            with_std(fit.gravity_m_s2, fit.gravity_m_s2_std, 2), with_std(fit.offset_rad_s, fit.offset_rad_s_std, 3),
            with_std(fit.lag_s, fit.lag_s_std, 2), f"{fit.r2:.4f}", f"{100 * apart:.1f} %", f"{lost:.3f}"])
    return table(("flight", "K [rad/m]", "gravity [m/s²]", "offset [rad/s]", "lag [s]", "R²", "K, difference of halves",
                  "R² lost on the other half"), rows)


def actuator_table(names: Sequence[str], records: Sequence[FlightRecord]) -> str:
    """The steering actuator of each flight."""
    rows = []
    for name, record in zip(names, records, strict=True):
        fit = identify_actuator(record)
        rows.append([name, with_std(fit.dead_time_s, fit.dead_time_s_std, 3),
                     with_std(fit.rate_limit_per_s, fit.rate_limit_per_s_std, 3),
                     with_std(fit.saturation, fit.saturation_std, 3), f"{fit.actuator_r2:.4f}"])
    return table(("flight", "dead time [s]", "rate limit [1/s]", "saturation", "R²"), rows)


def prediction_table(records: Sequence[FlightRecord]) -> str:
    """The worst of the cross-fits, and the required values."""
    rows = [[f"{error.source} steering", f"{error.window_s:g} s", f"{error.rms_deg:.1f}", f"{error.end_rms_deg:.1f}",
             f"{_LIMITS_DEG[error.source, error.window_s]:g}"] for error in cross_predictions(records)]
    return table(("from", "windows", "RMS over all samples [deg]", "RMS at window ends [deg]", "required [deg]"), rows)


def spread_table(names: Sequence[str], records: Sequence[FlightRecord]) -> str:
    """How far one real eight is from the next."""
    rows = []
    for name, record in zip(names, records, strict=True):
        spread = eight_spread(record)
        seconds = f"{min(spread.seconds):.0f} to {max(spread.seconds):.0f} s"
        rows.append([name, str(spread.eights), seconds, ", ".join(f"{value:.1f}" for value in spread.rms_deg)])
    return table(("flight", "eights", "period", "eight to eight, RMS [deg]"), rows)


def flown_again_table() -> str:
    """`v3-flight` and `v3-flight-paper` in closed loop, without turbulence and with it."""
    laws = {
        "paper's law, P = 1/(e tau')": ("v3-flight-paper", {"FF_GAIN": 0.0}),
        "the same with feed-forward": ("v3-flight-paper", {}),
        "with prediction": ("v3-flight", {}),
    }
    rows = []
    for law, (name, parameters) in laws.items():
        cells = [law]
        for intensity in (0.0, _TURBULENCE):
            scenario = load_scenario(name)
            scenario.set("wind.turbulence_intensity", intensity, law)
            for parameter, value in parameters.items():
                scenario.set_parameter(parameter, value, law)
            cells.append(f"{_cross_track_deg(scenario):.2f}")
        rows.append(cells)
    return table(("law", "no turbulence [deg RMS]", f"intensity {_TURBULENCE:g} [deg RMS]"), rows)


def _cross_track_deg(scenario: Scenario) -> float:
    return math.degrees(run_scenario(scenario, RunOptions()).numbers["cross_track_rms_rad"])
