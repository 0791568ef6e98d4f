"""`kite-sitl identify`: the turning-rate law and the steering actuator, from a run log, a tlog or a real flight."""

import json
import math
import sys
from argparse import Namespace
from pathlib import Path
from typing import Any

from kite_analysis.flights.description import FlightDataError
from kite_analysis.flights.reader import read_record
from kite_analysis.flights.record import FlightRecord
from kite_analysis.identification.actuator_fit import ActuatorFit, identify_actuator
from kite_analysis.identification.plots import plot_identification
from kite_analysis.identification.turning_rate_fit import LawFit, identify_law
from sim_bridge.cli.plot_option import plot_path, save_plot
from sim_bridge.plants.turning_rate_settings import TurningRateSettings
from sim_bridge.runs.reader import read_scenario


def identify(options: Namespace) -> int:
    """`kite-sitl identify`."""
    source = Path(options.source)
    plot = plot_path(options, Path(f"{source.resolve().name.split('.')[0]}-identify.png"))
    record = read_record(source, Path(options.columns) if options.columns else None)
    if options.smooth is not None:
        record = record._replace(smoothing_s=options.smooth)
    record = record.between(options.from_s, options.to_s)
    if not record.selected.any():
        raise FlightDataError(f"{source}: no data between --from {options.from_s:g} and --to {options.to_s:g}; "
                              f"it lasts {record.time_s[-1]:.0f} s")
    try:
        law = identify_law(record, options.angle, _transport(source, options))
    except FlightDataError as error:
        raise FlightDataError(f"{source}: {error}") from error
    actuator, why_not = _actuator(record)
    numbers: dict[str, Any] = {"source": str(source), **_numbers(law, actuator), "actuator_missing": why_not}
    if record.attribution:
        numbers["attribution"] = record.attribution
    if plot:
        save_plot(plot_identification(record, law, actuator), plot)
        numbers["plot"] = str(plot)
    if options.json:
        print(json.dumps({name: _plain(value) for name, value in numbers.items()}))
    else:
        _print(record, law, actuator, numbers)
    return 0


def _transport(source: Path, options: Namespace) -> bool | None:
    """Whether to allow for meridian convergence: as asked, as the run's plant has it, or None: if possible."""
    if options.no_transport:
        return False
    if source.is_dir() and (source / "run.json").exists():
        plant = read_scenario(source).plant
        return not isinstance(plant, TurningRateSettings) or plant.transport
    return None


def _actuator(record: FlightRecord) -> tuple[ActuatorFit | None, str | None]:
    """The actuator, or why there is none: a flight without it still has its law."""
    try:
        return identify_actuator(record), None
    except FlightDataError as error:
        return None, str(error)


def _numbers(law: LawFit, actuator: ActuatorFit | None) -> dict[str, Any]:
    fields = dict.fromkeys(ActuatorFit._fields) if actuator is None else actuator._asdict()
    return {**law._asdict(), **fields}


def _plain(value: Any) -> Any:
    """JSON has no NaN."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _print(record: FlightRecord, law: LawFit, actuator: ActuatorFit | None, numbers: dict[str, Any]) -> None:
    """The table for a person."""
    print(f"{numbers['source']} ({record.title}): {law.seconds:.0f} s used, {law.angle}, {law.steering} steering, "
          f"{'with' if law.transport else 'without'} meridian convergence")
    print(f"turning-rate law, R2 {law.r2:.4f}")
    _line("K", law.k_rad_per_m, law.k_rad_per_m_std, "rad/m")
    _line("gravity", law.gravity_m_s2, law.gravity_m_s2_std, "m/s2")
    _line("offset", law.offset_rad_s, law.offset_rad_s_std, "rad/s")
    _line("lag", law.lag_s, law.lag_s_std, f"s of the rate on the {law.steering} steering",
          "none found in the search range")
    if actuator is None:
        print(f"no actuator: {numbers['actuator_missing']}")
    else:
        print(f"steering actuator, R2 {actuator.actuator_r2:.4f}")
        _line("dead time", actuator.dead_time_s, actuator.dead_time_s_std, "s")
        _line("rate limit", actuator.rate_limit_per_s, actuator.rate_limit_per_s_std, "per second")
        _line("saturation", actuator.saturation, actuator.saturation_std, "of the range",
              f"not reached: {actuator.steering_reached:.3f} of the range or more")
    if law.k_rad_per_m < 0.0:
        print("K is negative: the sign of the angle or of the steering is reversed", file=sys.stderr)
    if "plot" in numbers:
        print(f"plot: {numbers['plot']}")
    if record.attribution:
        print(record.attribution)


def _line(name: str, value: float | None, std: float | None, unit: str, missing: str = "not reached") -> None:
    if value is None or std is None:
        print(f"  {name:11}   {missing}")
    else:
        print(f"  {name:11} {value:8.4f} +- {std:.2g} {unit}")
