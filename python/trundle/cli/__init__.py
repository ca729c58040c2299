"""The `trundle` command: finds the verbs, reads the arguments, turns what goes wrong into an exit status.

A verb is one module of `trundle.cli.commands`; nothing here knows any of them by name.
"""

from __future__ import annotations

import argparse
import difflib
import sys
from collections.abc import Mapping, Sequence
from typing import NoReturn

from trundle import __version__
from trundle.cli.commands import Command, discover
from trundle.cli.exits import USAGE, run_guarded

__all__ = ["main"]


class Parser(argparse.ArgumentParser):
    """An argument parser whose complaint is one sentence and names the way to the help."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong with the arguments and leave with status 2."""
        self.exit(USAGE, f"{self.prog}: {message}; see `{self.prog} --help`\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments after the program's name; those of this process by default.

    Returns
    -------
    int
        0 answered, 2 unusable input, 1 anything else, 130 interrupted.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    return run_guarded(lambda: _run(arguments))


def _run(arguments: list[str]) -> int:
    commands = discover()
    complaint = unknown_verb_message(arguments, commands)
    if complaint:
        print(complaint, file=sys.stderr)
        return USAGE
    options = build_parser(commands).parse_args(arguments)
    return commands[options.verb].run(options)


def build_parser(commands: Mapping[str, Command]) -> Parser:
    """Return the parser of the whole command line, one subparser a verb."""
    parser = Parser(
        prog="trundle",
        description="Learn how an unknown object moves when pushed; name what a simulation of it left out.",
        epilog="`trundle VERB --help` shows a verb's options and an example. "
        "TRUNDLE_DEBUG=1 shows where an error came from.",
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
    return parser


def unknown_verb_message(arguments: Sequence[str], commands: Mapping[str, Command]) -> str | None:
    """Return a complaint with the nearest verbs if the first argument is meant as a verb and is none."""
    if not arguments or arguments[0].startswith("-") or arguments[0] in commands:
        return None
    near = difflib.get_close_matches(arguments[0], commands, n=2)
    hint = f"; did you mean {' or '.join(repr(name) for name in near)}?" if near else ";"
    return f"trundle: there is no verb {arguments[0]!r}{hint} `trundle --help` lists them"
