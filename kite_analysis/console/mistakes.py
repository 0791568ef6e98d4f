"""How the programs answer a mistake: in one line, with a suggestion."""

import argparse
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NoReturn


class Parser(argparse.ArgumentParser):
    """An argument parser that answers a mistake in one line, and shows examples as they are written.

    `prepare` gives it what it is to have, when that is first needed; see kite_analysis.console.verbs.
    """

    prepare: "Callable[[Parser], None] | None" = None

    def __init__(self, *args: Any, **keywords: Any) -> None:
        super().__init__(*args, allow_abbrev=False, **keywords)

    def prepare_all(self) -> None:
        """Have this parser and those of all its verbs prepared, for who wants to look at them."""
        self._be_prepared()
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                for parser in action.choices.values():
                    parser.prepare_all()

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:  # type: ignore[override]
        """As argparse does, prepared."""
        self._be_prepared()
        return super().parse_known_args(args, namespace)

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:  # type: ignore[override]
        """As argparse does, but with a suggestion for a misspelt option."""
        parsed, unknown = self.parse_known_args(args, namespace)
        if unknown:
            *_, last = self._path(parsed)
            last.error(f"{unknown[0]} is not an option{closest(unknown[0], last.options())}")
        return parsed

    def error(self, message: str) -> NoReturn:
        """One line, exit code 2."""
        separator = " " if message.endswith("?") else "; "
        self.exit(2, f"{self.prog}: {message}{separator}see {self.prog} --help\n")

    def options(self) -> list[str]:
        """The options of this parser, as they are typed."""
        return [name for action in self._actions for name in action.option_strings if name.startswith("--")]

    def _be_prepared(self) -> None:
        prepare, self.prepare = self.prepare, None
        if prepare:
            prepare(self)

    def _get_formatter(self) -> argparse.HelpFormatter:
        """Examples, and descriptions of several lines, are shown as they are written."""
        as_written = self.epilog or "\n" in (self.description or "")
        self.formatter_class = argparse.RawDescriptionHelpFormatter if as_written else argparse.HelpFormatter
        return super()._get_formatter()

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Name what a word may be; argparse's own words differ with the version of Python."""
        if action.choices is None or value in action.choices:
            return
        known = [str(choice) for choice in action.choices]
        near = closest(str(value), known)
        if isinstance(action, argparse._SubParsersAction):
            raise argparse.ArgumentError(None, f"no verb {value!r}{near or '; there are ' + ', '.join(known)}")
        if isinstance(action.choices, range):
            raise argparse.ArgumentError(action, f"{value} is outside {known[0]} to {known[-1]}")
        raise argparse.ArgumentError(action, f"{value!r} is not one of {', '.join(known)}{near}")

    def _path(self, parsed: argparse.Namespace) -> Iterator["Parser"]:
        """This parser and those of the verbs that were given, outermost first."""
        yield self
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction) and (name := getattr(parsed, action.dest, None)):
                yield from action.choices[name]._path(parsed)


def closest(word: str, known: Iterable[str]) -> str:
    """A half sentence that suggests the known word closest to `word`, or nothing."""
    import difflib  # noqa: PLC0415  for mistakes alone

    near = difflib.get_close_matches(word, list(known), n=1, cutoff=0.5)
    return f"; did you mean {near[0]}?" if near else ""
