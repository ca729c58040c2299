"""The verbs of the command line, one module each.

Each module has the attributes of `Command`. The verb is the name of the module without a trailing underscore
(`import_.py` is `import`) and with hyphens for other underscores. Put slow imports inside `run`, because
`trundle --help` imports every module.
"""

from __future__ import annotations

import argparse
import importlib
import pkgutil
from typing import Protocol, cast

__all__ = ["Command", "discover"]


class Command(Protocol):
    """Interface of a module in this package.

    A module may also define `EXAMPLE: str`, a command line that `--help` shows.
    """

    HELP: str
    """What the verb does, in one sentence."""

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Add the arguments of the verb to `parser`."""

    def run(self, args: argparse.Namespace) -> int:
        """Run the verb and return the exit status; raise `ValueError` for unusable input."""


def discover() -> dict[str, Command]:
    """Return the modules of this package by verb, sorted."""
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    return {
        name.rstrip("_").replace("_", "-"): cast("Command", importlib.import_module(f"{__name__}.{name}"))
        for name in names
    }
