"""The verbs of the command line, one module each.

A verb is a module here that has what `Command` names. Its verb is the module's name (`import_.py` is
`import`: an underscore at the end is dropped, others become hyphens). What is slow to import belongs inside
`run`, because `trundle --help` imports every module here.
"""

from __future__ import annotations

import argparse
import importlib
import pkgutil
from typing import Protocol, cast

__all__ = ["Command", "discover"]


class Command(Protocol):
    """What a module of this package provides; it may add `EXAMPLE: str`, a command line shown by `--help`."""

    HELP: str
    """One sentence: what the verb answers."""

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Declare the verb's own arguments on `parser`."""

    def run(self, args: argparse.Namespace) -> int:
        """Do the work and return the exit status; raise `ValueError` for input that cannot be used."""


def discover() -> dict[str, Command]:
    """Return the verbs by name, sorted.

    Returns
    -------
    dict of str to Command
        Each module of this package under its verb.
    """
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    return {
        name.rstrip("_").replace("_", "-"): cast("Command", importlib.import_module(f"{__name__}.{name}"))
        for name in names
    }
