"""kite-ground replay, log export and plot."""

import argparse
import contextlib
import math
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from ground.cli.completion import complete_files
from ground.cli.options import Connect, add_examples, positive
from ground.cli.terminal import tell
from ground.errors import UsageError
from ground.link.transports import open_transport
from ground.logs.csv_tables import write_flight, write_messages
from ground.logs.plot import flight_of, plot_log
from ground.logs.reader import MessageLog, read_message_log
from ground.logs.ulog import write_ulog
from ground.replay.keys import minutes, run
from ground.replay.player import Replay
from kite_analysis.console.optional_packages import ExtraMissingError
from kite_analysis.figures import save
from kite_analysis.picture_file import ENDINGS_IN_WORDS, FileRefusedError, check_new_file, check_picture
from protocol import dialect
from protocol.frame import Address

DEFAULT_TARGET = "udpout:127.0.0.1:14550"
_CSV, _ULOG = "csv", "ulog"
_ENDINGS = {_CSV: ".csv", _ULOG: ".ulg"}


def add_replay_options(verb: argparse.ArgumentParser) -> None:
    """Options of `replay`."""
    _add_log_file(verb, "  kite-ground replay flight.tlog\n"
                  "  kite-ground replay flight.tlog --speed 4 --from 60 --to-time 120 --loop")
    verb.add_argument("--speed", type=positive, default=1.0, metavar="N", help="times real time (default 1)")
    verb.add_argument("--to", default=DEFAULT_TARGET, metavar="LINK", help="address of the ground station, in the "
                      f"form of --link (default {DEFAULT_TARGET})")
    _add_times(verb, "--to-time")
    verb.add_argument("--loop", action="store_true", help="repeat the flight until Ctrl-C")


def add_export_options(verb: argparse.ArgumentParser) -> None:
    """Options of `log export`."""
    _add_log_file(verb, "  kite-ground log export flight.tlog\n  kite-ground log export flight.tlog --format ulog\n"
                  "  kite-ground log export flight.tlog --all --out messages/")
    verb.add_argument("--format", choices=list(_ENDINGS), default=_CSV, help="csv: one row per KITE_STATE; ulog: "
                      "everything, for PlotJuggler and pyulog (default csv)")
    verb.add_argument("--all", action="store_true", help="with csv: a folder with one file per message type")
    _add_output(verb, "the log's name with the format's extension")
    _add_system(verb)


def add_plot_options(verb: argparse.ArgumentParser) -> None:
    """Options of `plot`."""
    _add_log_file(verb, "  kite-ground plot flight.tlog\n  kite-ground plot flight.tlog --from 60 --out turn.svg")
    _add_output(verb, f"the log's name with .png; {ENDINGS_IN_WORDS} names the format")
    _add_times(verb, "--to")
    _add_system(verb)


def replay(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground replay."""
    log = _read(args.file)
    from_s, to_s = _times(log, args.from_s, args.to_s)
    began_s = time.monotonic()
    with contextlib.closing(open_transport(args.to)) as transport:
        again = Replay(log, transport, time.monotonic, args.speed, from_s, to_s, args.loop)
        tell(f"replaying {args.file} from {minutes(from_s)} to {minutes(to_s)} to {args.to}")
        run(again, time.monotonic, sys.stderr)
    print(f"{again.sent} messages replayed in {time.monotonic() - began_s:.1f} s, {again.answered} requests answered")
    if not again.bytes_received:
        _kind, _, where = args.to.partition(":")
        tell(f"no ground station answered: is one listening on {where}?")
    return 0


def export(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground log export."""
    if args.all and args.format != _CSV:
        raise UsageError(f"log export: --all goes with --format {_CSV}; {args.format} always holds everything")
    log = _read(args.file)
    if args.all:
        path = _output(args, f"{Path(args.file).stem}-csv")
        with _writing(path):
            print(f"{write_messages(log, path)} message types written to {path}, one file each")
        return 0
    vehicle = log.vehicle(args.system)
    path = _output(args, f"{Path(args.file).stem}{_ENDINGS[args.format]}")
    if args.format == _CSV:
        _check_states(log, vehicle)
        with _writing(path):
            print(f"{write_flight(log, vehicle, path)} rows written to {path}")
    else:
        with _writing(path):
            print(f"{write_ulog(log, vehicle, path)} messages written to {path}")
    return 0


def plot(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground plot."""
    log = _read(args.file)
    vehicle = log.vehicle(args.system)
    _check_states(log, vehicle)
    path = _output_name(args, f"{Path(args.file).stem}.png")
    _check(check_picture, path, args.force)
    flight = flight_of(log, vehicle, *_times(log, args.from_s, args.to_s))
    if not flight.record.time_s.size:
        raise UsageError(f"{args.file}: no state message between {flight.from_s:g} and {flight.to_s:g} s")
    if not flight.parameters.complete:
        tell(f"{args.file}: some parameters are not in the log: targets and limits may be missing from the plot")
    with _writing(path):
        save(plot_log(flight), path)
    print(f"{path} drawn")
    return 0


def _add_log_file(verb: argparse.ArgumentParser, examples: str) -> None:
    """What a verb takes that reads a log and needs no link."""
    add_examples(verb, examples)
    complete_files(verb.add_argument("file", metavar="FILE.tlog"))


def _add_force(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--force", action="store_true", help="overwrite existing files")


def _add_output(parser: argparse.ArgumentParser, what: str) -> None:
    complete_files(parser.add_argument("--out", metavar="FILE", help=f"output (default: {what})"))
    _add_force(parser)


def _add_times(parser: argparse.ArgumentParser, to: str) -> None:
    parser.add_argument("--from", dest="from_s", type=_time, default=0.0, metavar="S", help="start at this time of the "
                        "log, in seconds (default 0)")
    parser.add_argument(to, dest="to_s", type=_time, metavar="S", help="stop at this time (default: the end)")


def _add_system(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--system", type=int, choices=range(1, 256), metavar="ID",
                        help="system id of the kite, if the log has several")


def _time(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None
    if not 0.0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} must be 0 or more, and finite")
    return value


def _times(log: MessageLog, from_s: float, to_s: float | None) -> tuple[float, float]:
    """Start and end [s] within the log. Raises UsageError if nothing is left."""
    end_s = log.duration_s if to_s is None else min(to_s, log.duration_s)
    if from_s >= end_s:
        raise UsageError(f"{log.path}: lasts {log.duration_s:.1f} s: nothing of it is from {from_s:g} to {end_s:g} s")
    return from_s, end_s


def _read(path: str) -> MessageLog:
    log = read_message_log(path)
    for remark in log.remarks:
        tell(f"{path}: {remark}" if not remark.startswith(path) else remark)
    return log


def _check_states(log: MessageLog, vehicle: Address) -> None:
    if not any(isinstance(entry.message, dialect.MAVLink_kite_state_message) for entry in log.of(vehicle)):
        raise UsageError(f"{log.path}: holds no KITE_STATE of system {vehicle.system}: was STATE_HZ 0?")


def _output(args: argparse.Namespace, name: str) -> Path:
    """The path to write to. Raises UsageError if the file exists or cannot be written."""
    path = _output_name(args, name)
    _check(check_new_file, path, args.force)
    return path


def _output_name(args: argparse.Namespace, name: str) -> Path:
    """The path given by --out, or `name` next to the log."""
    return Path(args.out) if args.out else Path(args.file).with_name(name)


def _check(rule: Callable[[Path, bool], None], path: Path, force: bool) -> None:
    try:
        rule(path, force)
    except (FileRefusedError, ExtraMissingError) as error:
        raise UsageError(f"{error}") from None


@contextlib.contextmanager
def _writing(path: Path) -> Iterator[None]:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        raise UsageError(f"{error.filename or path}: cannot write: {error.strerror}") from None
