"""kite-ground param show, get, set and watch."""

import argparse
import contextlib
import fnmatch
import json

from ground.cli.completion import complete_names
from ground.cli.options import Connect, begin_verb, known_name, positive
from ground.cli.snapshot_option import add_snapshot_option, snapshot_store
from ground.cli.terminal import parameter_progress, tell
from ground.errors import GroundError, UsageError
from ground.parameters.file import format_value, parse_number
from ground.parameters.snapshot import SnapshotStore
from ground.parameters.view import Values, facts, is_changed, row, sheet, width
from ground.parameters.watch import watch
from ground.session import Session
from kite_analysis.console.mistakes import closest
from protocol.parameter_table import load_parameters


def add_show_options(verb: argparse.ArgumentParser) -> None:
    """Options of `param show`."""
    begin_verb(verb, "  kite-ground param show 'EIGHT_*'")
    complete_names(verb.add_argument("pattern", nargs="*", metavar="PATTERN",
                                     help="names, with * and ? (default: all)"))
    verb.add_argument("--changed", action="store_true", help="only those that are not at their default")
    _add_json(verb)


def add_get_options(verb: argparse.ArgumentParser) -> None:
    """Options of `param get`."""
    begin_verb(verb, "  kite-ground param get INNER_P")
    complete_names(verb.add_argument("name", metavar="NAME"))
    _add_json(verb)


def add_set_options(verb: argparse.ArgumentParser) -> None:
    """Options of `param set`."""
    begin_verb(verb, "  kite-ground param set INNER_P 1.8")
    complete_names(verb.add_argument("name", metavar="NAME"))
    verb.add_argument("value", metavar="VALUE")
    add_snapshot_option(verb)


def add_watch_options(verb: argparse.ArgumentParser) -> None:
    """Options of `param watch`."""
    begin_verb(verb, "  kite-ground param watch 'INNER_*' OUTER_L")
    complete_names(verb.add_argument("pattern", nargs="*", metavar="PATTERN",
                                     help="names, with * and ? (default: all)"))
    verb.add_argument("--every", type=positive, metavar="S", default=5.0,
                      help="read all of them this often, in seconds (default 5)")
    verb.add_argument("--duration", type=positive, metavar="S", help="stop after this many seconds")


def show_parameters(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground param show."""
    table = load_parameters()
    with connect() as session:
        session.check_contract()
        values = session.parameters.fetch_all(parameter_progress())
    chosen = _matching(values, args.pattern)
    if args.changed:
        chosen = {name: value for name, value in chosen.items() if is_changed(table.get(name), value)}
    if args.json:
        print(json.dumps({name: facts(table.get(name), value) for name, value in chosen.items()}, indent=2))
        return 0
    columns = width()
    for name, value in chosen.items():
        print(row(name, table.get(name), value)[:columns])
    if args.changed and not chosen:
        tell("all of them are at their defaults")
    return 0


def get_parameter(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground param get."""
    name = known_name(args.name, load_parameters())
    with connect() as session:
        session.check_contract()
        value = session.parameters.fetch(name)
    parameter = load_parameters()[name]
    print(json.dumps({"name": name, **facts(parameter, value)}) if args.json
          else "\n".join(sheet(name, parameter, value)))
    return 0


def set_parameter(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground param set."""
    name = known_name(args.name, load_parameters())
    try:
        value = parse_number(args.value)
    except ValueError as error:
        raise UsageError(f"{name}: {error}") from None
    with connect() as session:
        session.check_contract()
        snapshots = snapshot_store(args, session)
        kept = _protect(session, snapshots, name)
        written = session.parameters.set(name, value)
        unit = load_parameters()[name].unit
        print(f"{name} = {format_value(written)} {unit}".rstrip() + ", acknowledged by the kite", flush=True)
        if kept:
            snapshots.finish(parameter_progress())
    return 0


def watch_parameters(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground param watch."""
    with connect() as session, contextlib.suppress(KeyboardInterrupt):
        session.check_contract()
        values = session.parameters.fetch_all(parameter_progress())
        chosen = _matching(values, args.pattern)
        for name, value in chosen.items():
            print(row(name, load_parameters().get(name), value), flush=True)
        watch(session.connection, chosen, args.every, args.duration or float("inf"),
              lambda text: print(text, flush=True))
    return 0


def _add_json(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("--json", action="store_true", help="print JSON for a script")


def _protect(session: Session, snapshots: SnapshotStore, name: str) -> bool:
    """Save `name` in the snapshot; return whether that worked. A full disk must not prevent a gain change in flight."""
    try:
        snapshots.protect(name)
    except UsageError as error:
        session.notice(f"warning: no snapshot: {error}")
        return False
    except GroundError:
        return False  # the set itself may still succeed, and reports its own errors
    return True


def _matching(values: Values, patterns: list[str]) -> Values:
    chosen: Values = {}
    for pattern in patterns or ["*"]:
        found = {name: value for name, value in values.items() if fnmatch.fnmatchcase(name, pattern.upper())}
        if not found:
            raise UsageError(f"no parameter matches {pattern!r}{closest(pattern.upper(), values)}")
        chosen |= found
    return {name: value for name, value in values.items() if name in chosen}
