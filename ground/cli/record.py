"""kite-ground record."""

import argparse
import contextlib

from ground.cli.completion import complete_files
from ground.cli.options import Connect, begin_verb, positive
from ground.cli.terminal import parameter_progress, tell
from ground.errors import VehicleError
from ground.logs.recorder import Recorder
from ground.session import Session


def add_record_options(verb: argparse.ArgumentParser) -> None:
    """Options of `record`."""
    begin_verb(verb, "  kite-ground record flight.tlog")
    complete_files(verb.add_argument("file", metavar="FILE.tlog"))
    verb.add_argument("--duration", type=positive, metavar="S", help="stop after this many seconds")
    verb.add_argument("--force", action="store_true", help="overwrite an existing file")


def record(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground record."""
    with connect() as session:
        offset_s = args.wall_clock() - session.connection.clock()
        with Recorder(session.connection, args.file, offset_s, args.force) as recorder:
            tell(f"recording to {args.file}; Ctrl-C stops")
            with contextlib.suppress(KeyboardInterrupt):
                _ask_for_parameters(session)
                left_s = float("inf") if args.duration is None else max(args.duration - recorder.elapsed_s, 0.0)
                session.connection.wait_until(lambda: False, left_s)
        statistics = session.connection.statistics
    total = statistics.received + statistics.lost
    lost = f", {statistics.lost / total:.1%} of the kite's messages were lost" if total else ""
    print(f"{recorder.frames} messages in {recorder.elapsed_s:.0f} s recorded to {args.file} "
          f"({recorder.bytes / 1e6:.1f} MB){lost}")
    return 0


def _ask_for_parameters(session: Session) -> None:
    """Request all parameters, so that the log has them; record even if some do not arrive."""
    try:
        session.parameters.fetch_all(parameter_progress())
    except VehicleError as error:
        tell(f"some parameters are not in the log: {error}")
