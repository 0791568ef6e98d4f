"""The verbs of a program as a table. What a verb needs is imported once it has been chosen, and no sooner.

    add_verbs(parser, (
        Verb("arm", "arm the kite", "ground.cli.vehicle:add_arm_options", "ground.cli.vehicle:arm"),
    ))
    options = parser.parse_args()
    options.run(options)
"""

from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from typing import Any, NamedTuple

from kite_analysis.console.mistakes import Parser


class Verb(NamedTuple):
    """A verb of a program, or with `verbs` a group of them; its functions are written "module:function".

    `options` gives the verb's parser its options and texts, before the command line is read. `run` does the work: the
    namespace that the command line becomes has it as `run`, and its module is imported when that is called.
    """

    name: str
    summary: str  # a line of the program's help
    options: str = ""
    run: str = ""
    verbs: tuple["Verb", ...] = ()


def add_verbs(parser: Parser, table: Sequence[Verb], dest: str = "verb") -> None:
    """Give `parser` the verbs of `table`; the name of the one that is chosen goes to `dest`."""
    verbs = parser.add_subparsers(dest=dest, required=True, metavar="VERB")
    for verb in table:
        sentence = f"{verb.summary[0].upper()}{verb.summary[1:]}."
        verbs.add_parser(verb.name, help=verb.summary, description=sentence).prepare = partial(_prepare, verb)


def function_called(name: str) -> Callable[..., Any]:
    """The function that is written "module:function"."""
    module, _, function = name.partition(":")
    return getattr(import_module(module), function)


def _prepare(verb: Verb, parser: Parser) -> None:
    if verb.options:
        function_called(verb.options)(parser)
    if verb.verbs:
        add_verbs(parser, verb.verbs, f"{verb.name}_verb")
    else:
        parser.set_defaults(run=partial(_run, verb.run))


def _run(name: str, *arguments: Any) -> Any:
    return function_called(name)(*arguments)
