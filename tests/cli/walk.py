"""Inspection of the parsers of the command line."""

import argparse
from collections.abc import Iterator
from pathlib import Path

from trundle.cli import build_parser
from trundle.cli.commands import discover


def leaves(parser: argparse.ArgumentParser | None = None) -> Iterator[tuple[str, ...]]:
    """Yield each verb, or each of its sub-verbs."""
    parser = build_parser(discover()) if parser is None else parser
    choices = subparsers(parser)
    for name, child in choices.items():
        for rest in leaves(child):
            yield (name, *rest)
    if not choices:
        yield ()


def find(path: tuple[str, ...]) -> argparse.ArgumentParser:
    """Return the parser of a verb."""
    parser: argparse.ArgumentParser = build_parser(discover())
    for name in path:
        parser = subparsers(parser)[name]
    return parser


def subparsers(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """Return the parsers below `parser`, none for a leaf."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            return dict(action.choices)
    return {}


def reads_a_file(path: tuple[str, ...]) -> bool:
    """Return whether the verb requires a path."""
    return any(action.type is Path for action in required(find(path)) if action.dest != "out")


def with_missing_files(path: tuple[str, ...]) -> list[str]:
    """Return the shortest command line of a verb, with missing input files."""
    line = list(path)
    for action in required(find(path)):
        value = "written" if action.dest == "out" else f"missing/{action.dest}"
        line += [*action.option_strings[-1:], value if action.type is Path else str(default_of(action))]
    return line


def required(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    """Return the required arguments."""
    return [action for action in parser._actions if action.required]


def default_of(action: argparse.Action) -> object:
    """Return a valid value of an argument."""
    return next(iter(action.choices)) if action.choices else 1
