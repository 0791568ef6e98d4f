"""kite-ground param load, revert and snapshot: sets many parameters, after showing what will change."""

import argparse
from pathlib import Path

from ground.cli.completion import complete_files, complete_names
from ground.cli.options import Connect, begin_verb, known_name
from ground.cli.parameter_files import SNAPSHOT, show_differences
from ground.cli.snapshot_option import add_snapshot_option, snapshot_store
from ground.cli.terminal import confirm, parameter_progress, tell
from ground.errors import NoAnswerError, UsageError, VehicleError
from ground.parameters.changes import Change, ChangeState, count_states
from ground.parameters.check import CheckedFile
from ground.parameters.file import format_value
from ground.parameters.snapshot import describe_age
from ground.parameters.view import Values, counted
from ground.session import Session
from protocol.parameter_table import load_parameters


def add_load_options(verb: argparse.ArgumentParser) -> None:
    """Options of `param load`."""
    begin_verb(verb, "  kite-ground param load before.param")
    complete_files(verb.add_argument("file", metavar="FILE"))
    verb.add_argument("--rest", action="store_true", help="if some lines cannot be sent, send the others")
    _add_yes(verb)
    add_snapshot_option(verb)


def add_revert_options(verb: argparse.ArgumentParser) -> None:
    """Options of `param revert`."""
    begin_verb(verb, "  kite-ground param revert\n  kite-ground param revert INNER_P OUTER_L")
    complete_names(verb.add_argument("name", metavar="NAME", nargs="*", help="only these (default: all)"))
    _add_yes(verb)
    add_snapshot_option(verb)


def add_snapshot_options(verb: argparse.ArgumentParser) -> None:
    """Options of `param snapshot`."""
    begin_verb(verb, "  kite-ground param snapshot")
    add_snapshot_option(verb)


def _add_yes(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("--yes", action="store_true", help="do not ask for confirmation")


def load_file(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground param load."""
    table = load_parameters()
    file = CheckedFile(args.file, table)
    if file.problems and not args.rest:
        file.match(table, "no parameter is called")  # by the table: name every bad line before connecting
        _refuse(file, args)
    with connect() as session:
        session.check_contract()
        values = session.parameters.fetch_all(parameter_progress())
        file.match(values)
        _refuse(file, args)
        for problem in file.problems:
            tell(f"{problem}; skipped")
        snapshots = snapshot_store(args, session)
        snapshots.complete(values)
        return _settle(args, session, values, file.wanted, Path(args.file).name)


def revert(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground param revert."""
    names = [known_name(name, load_parameters()) for name in args.name]
    with connect() as session:
        session.check_contract()
        snapshots = snapshot_store(args, session)
        snapshot = snapshots.find()
        if snapshot is None:
            earlier = f"; the one in {snapshots.path} is from before that" if snapshots.path.exists() else ""
            raise UsageError("nothing to restore: no parameter was changed from this computer since the kite was "
                             f"started{earlier}")
        if missing := [name for name in names if name not in snapshot.values]:
            raise UsageError(f"{missing[0]}: is not in the snapshot of {describe_age(snapshot, args.wall_clock())}")
        print(f"snapshot of {describe_age(snapshot, args.wall_clock())}")
        values = session.parameters.fetch_all(parameter_progress())
        wanted = {name: value for name, value in snapshot.values.items()
                  if name in values and (not names or name in names)}
        return _settle(args, session, values, wanted, SNAPSHOT)


def take_snapshot(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground param snapshot."""
    with connect() as session:
        snapshots = snapshot_store(args, session)
        values = snapshots.renew(parameter_progress())
    print(f"{counted(len(values))} kept in {snapshots.path}; `kite-ground param revert` restores them")
    return 0


def _refuse(file: CheckedFile, args: argparse.Namespace) -> None:
    """Raise UsageError if the file has problems, unless --rest was given."""
    problems = file.problems
    if not problems or args.rest:
        return
    for problem in problems if len(problems) > 1 else []:
        tell(problem)
    what = problems[0] if len(problems) == 1 else f"{file.path}: {len(problems)} lines cannot be sent"
    raise UsageError(f"{what}; nothing was set (--rest sends the others)")


def _settle(args: argparse.Namespace, session: Session, values: Values, other: Values, heading: str) -> int:
    """Show the differences, ask, and set them."""
    table = load_parameters()
    wanted = {name: value for name, value in other.items() if value != values[name]}
    show_differences(values, wanted, heading)
    for name in [name for name in wanted if name in table and table[name].read_only]:
        tell(f"{name} is read-only and stays as it is")
        del wanted[name]
    if not wanted:
        print("nothing to set")
        return 0
    if not args.yes and not confirm(session, f"set {counted(len(wanted))}?"):
        print("nothing was set")
        return 0
    return _set_all(session, [Change(name, values[name], value) for name, value in wanted.items()])


def _set_all(session: Session, changes: list[Change]) -> int:
    """Set each; a refusal does not stop the others, a silent vehicle does."""
    parameters = session.parameters
    try:
        parameters.write(changes, _tell_acknowledged)
    except NoAnswerError:
        for change in changes:
            if change.state in (ChangeState.SENT, ChangeState.EDITED):
                tell(f"{change.name} = {format_value(change.wanted)}: {change.state.value}")
        raise
    finally:
        print(f"{counted(len(changes))}: {count_states(changes)}; {_retried(parameters.retries)}", flush=True)
    refused = [change for change in changes if change.state is ChangeState.REFUSED]
    for change in refused:
        tell(change.reason)
    if refused:
        raise VehicleError(f"{len(refused)} of {counted(len(changes))} refused: "
                           f"{', '.join(change.name for change in refused)}")
    return 0


def _retried(number: int) -> str:
    return f"{number} {'retry' if number == 1 else 'retries'}"


def _tell_acknowledged(change: Change) -> None:
    if change.state is ChangeState.ACKNOWLEDGED:
        print(f"{change.name} = {format_value(change.wanted)}, acknowledged by the kite", flush=True)
