"""Options of `kite-sitl identify`."""

import math
from argparse import ArgumentParser

from sim_bridge.cli.option_types import not_negative
from sim_bridge.cli.plot_option import add_plot_option

_DESCRIPTION = """\
Fit the turning-rate law and the steering actuator to a flight:

  d(psi)/dt = K Va u + offset + gravity / Va sin(psi) cos(elevation) + meridian convergence

SOURCE is the folder that `run --log` wrote, a .tlog, or a CSV file of a real flight (gzipped or not; --columns
describes its columns; by default those of the public V3 flight of 8 October 2019, of which the reel-out is used).

Uncertainties are standard deviations that allow for residuals correlated over seconds. An actuator limit
that the flight never reached is not reported. The dead time counts from the recorded command: in a run log and
a tlog, from when it leaves the firmware, so it includes the delay of the steering's link."""
EPILOG = """\
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


def add_identify_options(verb: ArgumentParser) -> None:
    """Options of `identify`."""
    verb.description, verb.epilog = _DESCRIPTION, EPILOG
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
