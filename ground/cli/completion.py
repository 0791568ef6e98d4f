"""kite-ground completion: a script that completes verbs, options, files and parameter names in the shell."""

import argparse

from ground.cli.options import Connect, begin_verb
from ground.errors import UsageError
from protocol.parameter_table import load_parameters

SHELLS = ("bash", "zsh", "fish")


def add_completion_options(verb: argparse.ArgumentParser) -> None:
    """Options of `completion`."""
    begin_verb(verb, '  eval "$(kite-ground completion bash)"\n'
               "  kite-ground completion fish > ~/.config/fish/completions/kite-ground.fish")
    verb.add_argument("shell", choices=SHELLS)


def print_completion(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground completion."""
    try:
        import shtab  # noqa: PLC0415  (an extra)
    except ImportError:
        raise UsageError("completion needs shtab: pip install 'kitepilot[completion]'") from None
    args.whole_parser.prepare_all()
    print(shtab.complete(args.whole_parser, shell=args.shell))
    return 0


def complete_names(argument: argparse.Action) -> None:
    """Complete parameter names for this argument."""
    names = " ".join(load_parameters())
    argument.complete = {  # type: ignore[attr-defined]  (read by shtab)
        "bash": "_kite_ground_names", "zsh": f"({names})", "fish": f"(string split ' ' -- '{names}')",
        "preamble": {"bash": f"_kite_ground_names() {{ compgen -W '{names}' -- \"${{1^^}}\"; }}"}}


def complete_files(argument: argparse.Action) -> None:
    """Complete file names for this argument."""
    argument.complete = {  # type: ignore[attr-defined]
        "bash": "_shtab_compgen_files", "zsh": "_files", "fish": "(__fish_complete_path (commandline -ct))"}
