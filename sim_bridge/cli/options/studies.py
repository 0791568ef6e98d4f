"""Options of `kite-sitl paper`, `shadow`, `validate` and `bench`."""

from argparse import ArgumentParser

from sim_bridge.cli.option_types import add_interpreter_option, add_loop_option, count, positive
from sim_bridge.cli.options.listings import add_json_option
from sim_bridge.cli.plot_option import add_plot_option
from sim_bridge.runs.run_choices import RUNTIMES
from sim_bridge.scenario.plant_names import PLANTS, TURNING_RATE


def add_paper_options(verb: ArgumentParser) -> None:
    """Options of `paper`."""
    verb.add_argument("--out", metavar="DIR", default="paper", help="folder to write into (default: paper)")
    verb.add_argument("--plant", choices=PLANTS, default=TURNING_RATE,
                      help=f"the plant to fly, with its own set of tether, eight and gains (default: {TURNING_RATE})")
    verb.add_argument("--force", action="store_true", help="overwrite existing figures")
    add_loop_option(verb)
    add_json_option(verb)


def add_shadow_options(verb: ArgumentParser) -> None:
    """Options of `shadow`."""
    verb.description = (
        "Feed the samples of a recorded flight to the firmware over MAVLink, and compare the turning angle "
        "that it finds from positions alone with the recorded course. Its steering has no effect.")
    verb.add_argument("file", metavar="FILE", help="a flight, CSV or CSV.gz")
    verb.add_argument("--columns", metavar="FILE.toml", help="what the columns of FILE mean "
                      "(docs/flight-files.md; default: those of the public V3 flight)")
    verb.add_argument("--runtime", choices=RUNTIMES, default="cpython", help="default: cpython")
    add_interpreter_option(verb)
    add_loop_option(verb)
    add_plot_option(verb, "plot the firmware's turning angle and the recorded one", "NAME-shadow.png here")
    add_json_option(verb)


def add_validate_options(verb: ArgumentParser) -> None:
    """Options of `validate`."""
    verb.description = (
        "Identify the turning-rate law on real flights and on every plant, fly them, and write the tables "
        "as a Markdown page. Takes some minutes.")
    verb.add_argument("files", nargs="+", metavar="FLIGHT", help="two or more real flights, CSV or CSV.gz")
    verb.add_argument("--out", metavar="FILE.md", default="validation.md", help="the page (default: validation.md)")
    verb.add_argument("--force", action="store_true", help="overwrite an existing page")
    add_loop_option(verb)


def add_bench_options(verb: ArgumentParser) -> None:
    """Options of `bench`."""
    verb.description = (
        "Measure how fast scenarios fly in this process: the compiled loop beside the interpreted one, in turns, with\n"
        "the median and the spread of their flights. With --runtime micropython: memory and time of a tick.")
    verb.epilog = (
        "examples:\n"
        "  kite-sitl bench\n"
        "  kite-sitl bench --scenario v3-flight --runs 15\n"
        "  kite-sitl bench --before ../kitepilot-of-last-month --out docs/speed.md --force\n"
        "  kite-sitl bench --runtime micropython")
    verb.add_argument("--runtime", choices=("inproc", "micropython"), default="inproc",
                      help="inproc: simulation speed; micropython: memory and time of a tick (default: inproc)")
    add_interpreter_option(verb)
    verb.add_argument("--scenario", metavar="NAME",
                      help="scenario to fly (default: six of all plants; small-kite for micropython)")
    verb.add_argument("--duration", type=positive, metavar="S",
                      help="simulated seconds (default: 60; 600 for micropython)")
    verb.add_argument("--runs", type=count, default=5, metavar="N",
                      help="flights with each loop, 5 or more (default: 5)")
    verb.add_argument("--before", metavar="DIR",
                      help="compare with the interpreted loop of another checkout, too, with a .venv of its own")
    verb.add_argument("--out", metavar="FILE.md", help="also write the table as a page, such as docs/speed.md")
    verb.add_argument("--force", action="store_true", help="overwrite an existing page")
    add_json_option(verb)
