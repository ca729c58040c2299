"""The `trundle` command: finds the verbs, parses the arguments and converts errors to an exit status.

Each verb is one module of `trundle.cli.commands`. This module does not refer to any verb by name.
"""

from __future__ import annotations

import argparse
import difflib
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NoReturn

from trundle import __version__
from trundle.cli.commands import Command, discover
from trundle.cli.exits import USAGE, run_guarded
from trundle.cli.paths import check_paths

__all__ = ["main"]


class Parser(argparse.ArgumentParser):
    """An argument parser with one-line errors that refer to `--help`."""

    def error(self, message: str) -> NoReturn:
        """Print the error and exit with status 2."""
        self.exit(USAGE, f"{self.prog}: {message}; see `{self.prog} --help`\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments after the program name; by default those of this process.

    Returns
    -------
    int
        Exit status: 0 success, 1 other failure, 2 unusable input or arguments, 130 interrupted.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    return run_guarded(lambda: _run(arguments))


def _run(arguments: list[str]) -> int:
    commands = discover()
    message = unknown_verb_message(arguments, commands)
    if message:
        print(message, file=sys.stderr)
        return USAGE
    parser = build_parser(commands)
    options, unknown = parser.parse_known_args(arguments)
    if unknown:
        options.parser.error(unknown_argument_message(unknown[0], options.parser))
    check_paths(options)
    return commands[options.verb].run(options)


def build_parser(commands: Mapping[str, Command]) -> Parser:
    """Return the parser of the command line, with one subparser per verb."""
    parser = Parser(
        prog="trundle",
        description="Estimate how an unknown object moves when pushed, and name the physics that "
        "a simulation of it is missing.",
        epilog="Run `trundle VERB --help` for the options of a verb and an example. "
        "Set TRUNDLE_DEBUG=1 to print the traceback of an error.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"trundle {__version__}")
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True, title="verbs")
    for name, command in commands.items():
        example = getattr(command, "EXAMPLE", None)
        subparser = verbs.add_parser(
            name,
            help=command.HELP,
            description=command.HELP,
            epilog=f"example:\n  {example}" if example else None,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
        command.add_arguments(subparser)
        subparser.set_defaults(parser=subparser)
    return parser


def unknown_verb_message(arguments: Sequence[str], commands: Mapping[str, Command]) -> str | None:
    """Return an error message with similar verbs if the first argument is an unknown verb; else None."""
    if not arguments or arguments[0].startswith("-") or arguments[0] in commands:
        return None
    later = next((argument for argument in arguments[1:] if argument in commands), None)
    if later is not None:
        rest = [argument for argument in arguments if argument != later]
        line = shlex.join(["trundle", later, *rest])
        return f"trundle: {arguments[0]!r} is not a verb; the verb comes first: `{line}`"
    near = difflib.get_close_matches(arguments[0], commands, n=2)
    hint = f"; did you mean {' or '.join(repr(name) for name in near)}?" if near else ";"
    if not near and Path(arguments[0]).exists():
        hint = " (a verb comes before a path);"
    return f"trundle: unknown verb {arguments[0]!r}{hint} `trundle --help` lists all verbs"


def unknown_argument_message(argument: str, parser: argparse.ArgumentParser) -> str:
    """Return an error message about an argument that a verb does not have, with a similar option."""
    if not argument.startswith("-"):
        return f"unexpected argument {argument!r}; quote names that contain spaces"
    name = argument.partition("=")[0]
    options = [option for action in parser._actions for option in action.option_strings]
    near = difflib.get_close_matches(name, options, n=1)
    return f"unknown option {name!r}{f'; did you mean {near[0]!r}?' if near else ''}"
