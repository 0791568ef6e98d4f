"""`kite-sitl identify`: the turning-rate law and the steering actuator, from a run log, a tlog or a real flight."""

import json
import math
import sys
from argparse import Namespace, RawDescriptionHelpFormatter
from pathlib import Path
from typing import Any

from kite_analysis.flights.description import FlightDataError
from kite_analysis.flights.reader import read_record
from kite_analysis.flights.record import FlightRecord
from kite_analysis.identification.actuator_fit import ActuatorFit, identify_actuator
from kite_analysis.identification.plots import plot_identification
from kite_analysis.identification.turning_rate_fit import LawFit, identify_law
from sim_bridge.cli.option_types import not_negative
from sim_bridge.cli.plot_option import add_plot_option, plot_path, save_plot
from sim_bridge.plants.turning_rate_settings import TurningRateSettings
from sim_bridge.runs.reader import read_scenario

_DESCRIPTION = """\
Fit the turning-rate law and the steering actuator to a flight:

  d(psi)/dt = K Va u + offset + gravity / Va sin(psi) cos(elevation) + meridian convergence

SOURCE is the folder that `run --log` wrote, a .tlog, or a CSV file of a real flight (gzipped or not; --columns
describes its columns; by default those of the public V3 flight of 8 October 2019, of which the reel-out is used).

Uncertainties are standard deviations that allow for residuals correlated over seconds. An actuator limit
that the flight never reached is not reported. The dead time counts from the recorded command: in a run log and
a tlog, from when it leaves the firmware, so it includes the delay of the steering's link."""
_EPILOG = """\
examples:
  kite-sitl identify tests/data/flight/20191008_0010.csv.gz --plot
  kite-sitl run v3-flight --log flight && kite-sitl identify flight --json
  kite-sitl identify ours.csv --columns ours.toml --angle course --from 30 --to 120

ours.toml, for --columns (docs/flight-files.md has every key):
  title = "our kite"
  [columns]
  time = { column = "t", unit = "s", fraction = "t_us", fraction_unit = "us" }   # fraction only where it is apart
  elevation = { column = "el", unit = "deg" }
  azimuth = { column = "az", unit = "deg", sign = -1 }                           # ours is anticlockwise from above
  heading = { column = "psi", unit = "deg", sign = -1 }                          # or course, or both
  airspeed = { column = "va", unit = "m/s" }
  steering = { column = "u", unit = "%" }                                        # or set_steering, or both
  [phase]                                                                        # optional: the rows to use
  column = "phase"
  values = ["reel-out"]"""


def add_identify_verb(verbs: Any) -> None:
    """Add `identify` to the parser."""
    verb = verbs.add_parser(
        "identify", help="identify K, gravity and the steering actuator from a flight", description=_DESCRIPTION,
        epilog=_EPILOG, formatter_class=RawDescriptionHelpFormatter)
    verb.add_argument("source", metavar="SOURCE", help="a run log's folder, or a .tlog, .csv or .csv.gz file")
    verb.add_argument("--columns", metavar="FILE.toml", help="what the columns of a CSV file mean: see below")
    verb.add_argument("--from", dest="from_s", type=not_negative, default=0.0, metavar="S",
                      help="start here, in seconds since the first row")
    verb.add_argument("--to", dest="to_s", type=not_negative, default=math.inf, metavar="S", help="stop here")
    verb.add_argument("--angle", choices=("heading", "course"),
                      help="the angle to fit the law to (default: heading if recorded)")
    verb.add_argument("--no-transport", action="store_true",
                      help="leave out meridian convergence (default: as in the run's plant; otherwise "
                      "included if there is an azimuth)")
    verb.add_argument("--smooth", type=not_negative, metavar="S", help="smoothing width of the angle's rate "
                      "(default: 1.1 s for a real flight, 0.3 s for a tlog, none for a run log)")
    add_plot_option(verb, "plot measured and fitted rates", "NAME-identify.png here")
    verb.add_argument("--json", action="store_true", help="print JSON for a script")
    verb.set_defaults(do=identify)


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
