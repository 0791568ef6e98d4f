"""kite-ground param: show, get and set, and the subcommands that take a file."""

import argparse
import fnmatch
import json
import shutil
import sys

from ground.cli_options import Connect, add_command, closest, common_options, known_name
from ground.cli_parameter_files import add_parameter_file_commands
from ground.errors import UsageError
from ground.parameter_file import format_value, parse_number
from ground.terminal import parameter_progress, tell
from protocol.parameter_table import Parameter, load_parameters

Values = dict[str, float]


def add_parameter_commands(commands) -> None:
    """Add `param` and its subcommands."""
    group = commands.add_parser("param", help="show, set, save and load parameters", parents=[common_options()],
                                description="Show, set, save and load the vehicle's parameters.")
    verbs = group.add_subparsers(dest="verb", required=True, metavar="VERB")
    show = add_command(verbs, "show", show_parameters, "list parameters, with a * where one is not at its default",
                       "  kite-ground param show 'EIGHT_*'")
    show.add_argument("pattern", nargs="*", metavar="PATTERN", help="names, with * and ? (default: all)")
    show.add_argument("--changed", action="store_true", help="only those that are not at their default")
    get = add_command(verbs, "get", get_parameter, "show one parameter and what it means",
                      "  kite-ground param get INNER_P")
    get.add_argument("name", metavar="NAME")
    for parser in (show, get):
        parser.add_argument("--json", action="store_true", help="for a script")
    put = add_command(verbs, "set", set_parameter, "set one parameter, and wait until the vehicle acknowledges it",
                      "  kite-ground param set INNER_P 1.8")
    put.add_argument("name", metavar="NAME")
    put.add_argument("value", metavar="VALUE")
    add_parameter_file_commands(verbs)


def show_parameters(args: argparse.Namespace, connect: Connect) -> int:
    """param show."""
    table = load_parameters()
    with connect() as session:
        session.check_contract()
        values = session.parameters.fetch_all(parameter_progress())
    chosen = _matching(values, args.pattern)
    if args.changed:
        chosen = {name: value for name, value in chosen.items() if _changed(table.get(name), value)}
    if args.json:
        print(json.dumps({name: _facts(table.get(name), value) for name, value in chosen.items()}, indent=2))
        return 0
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else None
    for name, value in chosen.items():
        parameter = table.get(name)
        mark = "*" if _changed(parameter, value) else " "
        unit, text = (parameter.unit, _short(parameter.text)) if parameter else ("", "not known to this ground station")
        print(f"{mark} {name:<16} {format_value(value):>12} {unit:<6} {text}"[:width].rstrip())
    if args.changed and not chosen:
        tell("all of them are at their defaults")
    return 0


def get_parameter(args: argparse.Namespace, connect: Connect) -> int:
    """param get."""
    name = known_name(args.name, load_parameters())
    with connect() as session:
        session.check_contract()
        value = session.parameters.fetch(name)
    parameter = load_parameters()[name]
    if args.json:
        print(json.dumps({"name": name, **_facts(parameter, value)}))
        return 0
    print(f"{name} = {format_value(value)} {parameter.unit}".rstrip())
    notes = [f"{parameter.least:g} to {parameter.greatest:g}", f"default {parameter.default:g}"]
    notes += ["read only"] if parameter.read_only else ["only while disarmed"] if parameter.disarmed_only else []
    print(f"  {parameter.text}\n  {', '.join(notes)}")
    return 0


def set_parameter(args: argparse.Namespace, connect: Connect) -> int:
    """param set."""
    name = known_name(args.name, load_parameters())
    try:
        value = parse_number(args.value)
    except ValueError as error:
        raise UsageError(f"{name}: {error}") from None
    with connect() as session:
        session.check_contract()
        written = session.parameters.set(name, value)
    print(f"{name} = {format_value(written)} {load_parameters()[name].unit}".rstrip() + ", acknowledged by the vehicle")
    return 0


def _matching(values: Values, patterns: list[str]) -> Values:
    chosen: Values = {}
    for pattern in patterns or ["*"]:
        found = {name: value for name, value in values.items() if fnmatch.fnmatchcase(name, pattern.upper())}
        if not found:
            raise UsageError(f"no parameter matches {pattern!r}{closest(pattern.upper(), values)}")
        chosen |= found
    return {name: value for name, value in values.items() if name in chosen}


def _changed(parameter: Parameter | None, value: float) -> bool:
    return parameter is not None and value != parameter.default


def _facts(parameter: Parameter | None, value: float) -> dict[str, float | str | None]:
    shortest = float(format_value(value))
    if parameter is None:
        return {"value": shortest, "unit": None, "default": None, "least": None, "greatest": None}
    return {"value": shortest, "unit": parameter.unit, "default": parameter.default, "least": parameter.least,
            "greatest": parameter.greatest}


def _short(text: str) -> str:
    """The first clause of a parameter's documentation."""
    for end in (";", ":"):
        text = text.partition(end)[0]
    return text.rstrip(".")
