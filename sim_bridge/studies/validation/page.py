"""The page docs/validation.md, made by `kite-sitl validate`."""

import datetime
import platform
import textwrap
from collections.abc import Callable
from importlib import metadata
from pathlib import Path

from kite_analysis.flights.reader import read_record
from sim_bridge.studies.validation import plant_laws, real_flights

_WIDTH = 120  # columns
_HEAD = """\
# Validation: what the models are worth

Made by `make validate` on {date}, with kitepilot {version} under Python {python}; speeds are for one core of the
machine that made it.

{attribution}

## The turning-rate law on real flights

Least squares on the reel-out of each cycle (`kite-sitl identify FILE`): heading rate on airspeed times actual steering,
a constant, and gravity; meridian convergence is taken out first. ± is a standard deviation that allows for residuals
correlated over seconds. Each half's law is then compared with the other half.

"""


def page(files: list[Path], notice: Callable[[str], None]) -> str:
    """The page's text, from real flights in `files` (two or more); `notice` is told how far it has come.

    Raises:
        FlightDataError: a file holds no flight.
    """
    records = [read_record(path) for path in files]
    names = [path.name.split(".")[0] for path in files]
    text = _HEAD.format(date=datetime.datetime.now(datetime.UTC).date().isoformat(),
                        version=metadata.version("kitepilot"), python=platform.python_version(),
                        attribution=textwrap.fill(f"{records[0].attribution or records[0].title}.", _WIDTH))
    text += real_flights.law_table(names, records)
    text += "The steering actuator, from commanded to actual steering:\n\n"
    text += real_flights.actuator_table(names, records)
    notice("the real flights: identified")
    text += ("## Predicted heading\n\nThe law is integrated open loop with the recorded airspeed, from a fresh state "
             "at each window's start,\non flights that it was not fitted to. The table has the worst of all "
             "cross-fits.\n\n")
    text += real_flights.prediction_table(records)
    notice("the real flights: predicted")
    text += ("## The real flight, simulated\n\n`v3-flight` is the turning-rate plant with the identified values: "
             "cross-track error in closed loop,\nand the distance from one real eight to the next.\n\n")
    text += real_flights.flown_again_table() + real_flights.spread_table(names, records)
    notice("v3-flight: flown")
    text += "## The plants in closed loop\n\n" + plant_laws.closed_loop_table(notice)
    text += ("## Where the law holds\n\nIdentified from a minute of eights; R² is the fraction of the turning rate "
             "that the law explains.\n\n") + plant_laws.law_table(notice)
    text += ("K of the plants with forces, at the mean airspeed, as wind, line length and depower change; "
             "tether and eight are\notherwise those of the plant's set.\n\n") + plant_laws.variation_tables(notice)
    text += ("## The paper's flights on every plant\n\n`kite-sitl paper --plant NAME` draws them. L is 5, and the "
             "tether is so long that the kite flies\n0.2 line lengths per second.\n\n") + plant_laws.paper_table(notice)
    return text.rstrip() + "\n"
