"""kite-ground param save, savechanged and diff: writes parameters to a file, or compares with one."""

import argparse
from pathlib import Path

from ground.cli.completion import complete_files
from ground.cli.options import Connect, begin_verb
from ground.cli.snapshot_option import add_snapshot_option, snapshot_store
from ground.cli.terminal import parameter_progress
from ground.errors import UsageError
from ground.parameters.file import STYLES, read_parameter_file, write_parameter_file
from ground.parameters.snapshot import describe_age
from ground.parameters.view import Values, counted, differences, is_changed, width
from protocol.contract import CONTRACT_HASH
from protocol.parameter_table import load_parameters

SNAPSHOT = "snapshot"


def add_save_options(verb: argparse.ArgumentParser) -> None:
    """Options of `param save`."""
    begin_verb(verb, "  kite-ground param save before.param\n"
               "  kite-ground param save before.params --format qgroundcontrol")
    _add_file_options(verb)


def add_save_changed_options(verb: argparse.ArgumentParser) -> None:
    """Options of `param savechanged`."""
    begin_verb(verb, "  kite-ground param savechanged gains.param")
    _add_file_options(verb)


def _add_file_options(verb: argparse.ArgumentParser) -> None:
    complete_files(verb.add_argument("file", metavar="FILE"))
    verb.add_argument("--format", choices=list(STYLES), default="mavproxy", help="file format (default mavproxy)")
    verb.add_argument("--force", action="store_true", help="overwrite an existing file")


def add_difference_options(verb: argparse.ArgumentParser) -> None:
    """Options of `param diff`."""
    begin_verb(verb, "  kite-ground param diff before.param\n  kite-ground param diff --to-snapshot")
    complete_files(verb.add_argument("file", metavar="FILE", nargs="?", help="parameter file (default: compare with "
                                                                             "the defaults)"))
    verb.add_argument("--to-snapshot", action="store_true", help="compare with the snapshot, which `param revert` "
                                                                 "restores")
    add_snapshot_option(verb)


def save_parameters(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground param save."""
    return _save(args, connect, changed_only=False)


def save_changed(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground param savechanged."""
    return _save(args, connect, changed_only=True)


def show_difference(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground param diff. Sets nothing, and takes no snapshot."""
    table = load_parameters()
    if args.file and args.to_snapshot:
        raise UsageError("param diff: give FILE or --to-snapshot, not both")
    other, heading = {name: parameter.default for name, parameter in table.items()}, "default"
    if args.file:
        other, heading = {name: entry.value for name, entry in read_parameter_file(args.file).items()}, args.file
    with connect() as session:
        session.check_contract()
        if args.to_snapshot:
            snapshots = snapshot_store(args, session)
            snapshot = snapshots.find()
            if snapshot is None:
                raise UsageError(f"no snapshot of this flight: {snapshots.path} does not exist, or is from before the "
                                 "kite was started")
            print(f"snapshot of {describe_age(snapshot, args.wall_clock())}")
            other, heading = snapshot.values, SNAPSHOT
        values = session.parameters.fetch_all(parameter_progress())
    show_differences(values, {name: value for name, value in other.items() if values.get(name) != value}, heading)
    return 0


def show_differences(values: Values, wanted: Values, heading: str) -> None:
    """Print `wanted` next to the vehicle's `values`."""
    if not wanted:
        print(f"no difference between the kite and {heading}")
        return
    columns = width()
    for line in differences(load_parameters(), values, wanted, heading):
        print(line[:columns])


def _save(args: argparse.Namespace, connect: Connect, changed_only: bool) -> int:
    """Write only values reported by the vehicle, and only if all have been."""
    if Path(args.file).exists() and not args.force:
        raise UsageError(f"{args.file}: already exists: give another name, or --force to overwrite it")
    with connect() as session:
        session.check_contract()
        values = session.parameters.fetch_all(parameter_progress())
        system = session.connection.target.system
    table = load_parameters()
    if changed_only:
        values = {name: value for name, value in values.items() if name not in table or is_changed(table[name], value)}
        if not values:
            print(f"all parameters are at their defaults: {args.file} was not written")
            return 0
    heading = (f"kitepilot, system {system}, contract {CONTRACT_HASH}",)
    write_parameter_file(args.file, values, heading, args.format, system)
    print(f"{counted(len(values))} written to {args.file}")
    return 0
