"""kite-ground param save, load and diff: the vehicle's parameters against a file."""

import argparse
from pathlib import Path

from ground.cli_options import Connect, add_command, closest
from ground.errors import NoAnswerError, UsageError, VehicleError
from ground.parameter_file import Entry, format_value, read_parameter_file, write_parameter_file
from ground.session import Session
from ground.terminal import confirm, parameter_progress, tell
from protocol.contract import CONTRACT_HASH
from protocol.parameter_table import Parameter, load_parameters

Values = dict[str, float]


def add_parameter_file_commands(verbs) -> None:
    """Add the subcommands of `param` that take a file."""
    save = add_command(verbs, "save", save_parameters, "write all parameters to a file, as MAVProxy does",
                       "  kite-ground param save before.param")
    save.add_argument("file", metavar="FILE")
    save.add_argument("--force", action="store_true", help="write over a file that is there")
    load = add_command(verbs, "load", load_file, "set what a file (MAVProxy, Mission Planner, QGroundControl) has "
                       "different", "  kite-ground param load before.param")
    load.add_argument("file", metavar="FILE")
    load.add_argument("--yes", action="store_true", help="do not ask first")
    diff = add_command(verbs, "diff", show_difference, "show where the vehicle differs from a file, or from the "
                       "defaults", "  kite-ground param diff before.param")
    diff.add_argument("file", metavar="FILE", nargs="?", help="(default: the defaults)")


def save_parameters(args: argparse.Namespace, connect: Connect) -> int:
    """param save."""
    if Path(args.file).exists() and not args.force:
        raise UsageError(f"{args.file}: is there already: give another name, or --force to write over it")
    with connect() as session:
        session.check_contract()
        values = session.parameters.fetch_all(parameter_progress())
        system = session.connection.target.system
    write_parameter_file(args.file, values, f"kitepilot, system {system}, contract {CONTRACT_HASH}")
    print(f"{len(values)} parameters written to {args.file}")
    return 0


def load_file(args: argparse.Namespace, connect: Connect) -> int:
    """param load."""
    entries = read_parameter_file(args.file)
    table = load_parameters()
    _check_entries(args.file, entries, table)
    with connect() as session:
        session.check_contract()
        values = session.parameters.fetch_all(parameter_progress())
        _check_names(args.file, entries, values)
        wanted = {name: entry.value for name, entry in entries.items() if entry.value != values[name]}
        _print_differences(values, wanted, args.file)
        for name in [name for name in wanted if name in table and table[name].read_only]:
            tell(f"{name} is read only and stays as it is")
            del wanted[name]
        if not wanted:
            print("nothing to set")
            return 0
        if not args.yes and not confirm(session, f"set {_count(wanted)}?"):
            print("nothing was set")
            return 0
        return _set_all(session, wanted)


def show_difference(args: argparse.Namespace, connect: Connect) -> int:
    """param diff."""
    if args.file:
        other = {name: entry.value for name, entry in read_parameter_file(args.file).items()}
    else:
        other = {name: parameter.default for name, parameter in load_parameters().items()}
    with connect() as session:
        session.check_contract()
        values = session.parameters.fetch_all(parameter_progress())
    differing = {name: value for name, value in other.items() if values.get(name) != value}
    _print_differences(values, differing, args.file or "default")
    return 0


def _check_entries(file: str, entries: dict[str, Entry], table: dict[str, Parameter]) -> None:
    """Raise UsageError for a value that is certain to be refused, before anything is changed."""
    for name, entry in entries.items():
        parameter = table.get(name)
        problem = parameter.problem_with(entry.value) if parameter and not parameter.read_only else None
        if problem:
            raise UsageError(f"{file}:{entry.line}: {problem}; nothing was set")


def _check_names(file: str, entries: dict[str, Entry], values: Values) -> None:
    for name, entry in entries.items():
        if name not in values:
            raise UsageError(f"{file}:{entry.line}: the vehicle has no parameter {name}{closest(name, values)}; "
                             "nothing was set")


def _print_differences(values: Values, wanted: Values, heading: str) -> None:
    if not wanted:
        print(f"no difference between the vehicle and {heading}")
        return
    print(f"{'':<16} {'vehicle':>12} {heading:>12}")
    for name, value in wanted.items():
        present = format_value(values[name]) if name in values else "-"
        print(f"{name:<16} {present:>12} {format_value(value):>12}")


def _set_all(session: Session, wanted: Values) -> int:
    """Set each; a refusal does not stop the others, a vehicle that has fallen silent does."""
    refused = []
    for done, (name, value) in enumerate(wanted.items()):
        try:
            session.parameters.set(name, value)
            print(f"{name} = {format_value(value)}, acknowledged by the vehicle", flush=True)
        except NoAnswerError as error:
            rest = len(wanted) - done
            raise NoAnswerError(f"{error}; it and what followed ({rest} of {len(wanted)}) may be unset") from None
        except VehicleError as error:
            refused.append(name)
            tell(str(error))
    if refused:
        raise VehicleError(f"{len(refused)} of {_count(wanted)} refused: {', '.join(refused)}")
    return 0


def _count(wanted: Values) -> str:
    return f"{len(wanted)} parameter{'' if len(wanted) == 1 else 's'}"
