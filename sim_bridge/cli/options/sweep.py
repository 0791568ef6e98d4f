"""Options of `kite-sitl sweep`."""

from argparse import ArgumentParser

from kite_analysis.verdicts import RULE
from sim_bridge.cli.option_types import add_loop_option, count, positive
from sim_bridge.cli.plot_option import add_plot_option


def add_sweep_options(verb: ArgumentParser) -> None:
    """Options of `sweep`."""
    verb.description = (
        "Fly a scenario over a grid of values, or with --runs over a random sample of them, on all cores.\n"
        "Run number n flies with the seed run.seed + n. Results go into a CSV file, one line per run; the same "
        "command\nresumes an interrupted sweep. Runs with other code, defaults or wind do not\n"
        "get into the same file unless you say so.")
    verb.epilog = (
        f"verdict: {RULE}\n  refused       could not be flown; `trouble` says why\n\n"
        "values: FIRST:LAST:COUNT, FIRST:LAST:COUNT:log, or A,B,C\nexamples:\n"
        "  kite-sitl sweep paper-delay-tuned --over param.INNER_P=1:10:20 --over link.control.delay_s=.1:.5:5 --plot\n"
        "  kite-sitl sweep v3-flight --over wind.turbulence_intensity=0:0.3:2 --over param.INNER_P=1:3:2 --runs 99\n"
        "  kite-sitl sweep small-kite --over run.seed=1,2,3,4 --scheduler tcp://10.0.0.7:8786")
    verb.add_argument("scenario", metavar="NAME", help="a scenario of `kite-sitl list`, or a .toml file")
    verb.add_argument("--over", action="append", required=True, metavar="KEY=VALUES",
                      help="vary a key, `section.key` or `param.NAME`; may be repeated")
    verb.add_argument("--runs", type=count, metavar="N", help="fly N random points within the ranges instead of the "
                                                              "grid")
    verb.add_argument("--set", action="append", default=[], metavar="section.key=value", help="as for `kite-sitl run`")
    verb.add_argument("--param", action="append", default=[], metavar="NAME=value", help="as for `kite-sitl run`")
    verb.add_argument("--seed", type=int, help="seed of the sweep: of the sample, and of the first run (run.seed)")
    verb.add_argument("--duration", type=positive, metavar="S", help="length of each flight (run.duration_s)")
    verb.add_argument("--out", metavar="CSV", help="file of results (default: NAME-sweep.csv here)")
    verb.add_argument("--other-code", action="store_true",
                      help="resume although other code flew the existing runs; the column `code` tells them apart")
    verb.add_argument("--jobs", type=count, metavar="N", help="number of processes (default: one per core)")
    verb.add_argument("--scheduler", metavar="tcp://HOST:PORT", help="fly on the workers of this Dask scheduler")
    add_loop_option(verb)
    add_plot_option(verb, "plot the first two axes, with the limits from theory", "the CSV's name, .png")
    verb.add_argument("--json", action="store_true", help="print a summary as JSON")
