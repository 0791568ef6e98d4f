"""Options of `kite-sitl design`."""

from argparse import ArgumentParser

from protocol.parameter_table import load_parameters
from sim_bridge.cli.option_types import not_negative, positive
from sim_bridge.cli.plot_option import add_plot_option


def add_design_options(verb: ArgumentParser) -> None:
    """Options of `design`."""
    verb.description = (
        "Limits and best values of the gains P (INNER_P) and L (OUTER_L) for a delay: the paper's, for\n"
        "the inner loop alone, and those of inner and outer loop together. Both optima settle fastest on a target at\n"
        "rest; to follow an eight without FF_GAIN or prediction, a P near half its limit is better. See docs/delay.md.")
    verb.epilog = (
        "examples:\n"
        "  kite-sitl design --delay 0.2 --speed-over-length 0.45\n"
        "  kite-sitl design --delay 0.5 --speed-over-length 0.06 --gain-p 0.72 --gain-l 4 --plot v3.png\n"
        "  kite-sitl design --delay 0.15 --speed-over-length 0.45 --jitter 0.03 --loss 0.1 --lag 0.05")
    verb.add_argument("--delay", type=not_negative, required=True, metavar="S",
                      help="dead time tau of links and actuator together, without sampling [s]; 0 is allowed")
    verb.add_argument("--speed-over-length", type=positive, required=True, metavar="X",
                      help="the kite's speed across the sky over the line length [1/s]")
    table = load_parameters()
    rate, p, outer_l = (table[name].default for name in ("LOOP_HZ", "INNER_P", "OUTER_L"))
    verb.add_argument("--loop-hz", type=positive, default=rate, metavar="N", help=f"loop rate (default: {rate:g})")
    verb.add_argument("--gain-p", type=not_negative, default=p, metavar="P", help=f"present P (default: {p:g})")
    verb.add_argument("--gain-l", type=not_negative, default=outer_l, metavar="L",
                      help=f"present L (default: {outer_l:g})")
    verb.add_argument("--lag", type=not_negative, default=0.0, metavar="S",
                      help="time constant of the actuator, in addition to its dead time [s]")
    verb.add_argument("--jitter", type=not_negative, default=0.0, metavar="S",
                      help="jitter of each link direction, uniform, +- [s]")
    verb.add_argument("--loss", type=not_negative, default=0.0, metavar="SHARE",
                      help="fraction of frames lost, in each direction")
    verb.add_argument("--loss-burst", type=not_negative, default=0.0, metavar="N",
                      help="mean length of a loss burst in frames; up to 1: independent losses")
    add_plot_option(verb, "plot the decay rate over (P, L), and the roots", "design.png here")
    verb.add_argument("--json", action="store_true", help="print JSON for a script")
