"""The caller's own simulator on the command line: a function in a Python file, and its parameters."""

from __future__ import annotations

import argparse
import importlib.util
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trundle._native import TrundleError

__all__ = ["Simulator", "add_simulator", "select_simulator"]


@dataclass(frozen=True)
class Simulator:
    """A simulator as text, so that it can be passed to another process.

    Attributes
    ----------
    step : str
        FILE:NAME.
    parameters : tuple of str
        NAME=VALUE or NAME=START,LOWER,UPPER.
    vectorized : bool
        Whether the function takes several states at once.
    """

    step: str
    parameters: tuple[str, ...] = ()
    vectorized: bool = False

    def load(self) -> dict[str, Any]:
        """Import the function; return the arguments of `trundle.diagnose`.

        Raises
        ------
        TrundleError
            If the file does not exist, raises an exception or has no such function, or a parameter is not a
            number. The message names the argument and the remedy.
        """
        parameters = dict(parse_parameter(text) for text in self.parameters)
        return {
            "step": load_function(self.step),
            "parameters": parameters or None,
            "vectorized": self.vectorized,
        }

    @property
    def words(self) -> list[str]:
        """The arguments of the command line."""
        given = [word for text in self.parameters for word in ("--parameter", text)]
        return ["--step", self.step, *given, *(["--vectorized"] if self.vectorized else [])]


def add_simulator(parser: argparse.ArgumentParser) -> None:
    """Add `--step`, `--parameter` and `--vectorized`."""
    parser.add_argument(
        "--step",
        metavar="FILE:NAME",
        help="the function NAME of a Python file as a black-box simulator under test: "
        "step(state, wrench, dt, values) returns the state after dt (see docs/your-simulator.md)",
    )
    parser.add_argument(
        "--parameter",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="parameter of --step to refit: NAME=VALUE or NAME=START,LOWER,UPPER; may be repeated",
    )
    parser.add_argument(
        "--vectorized",
        action="store_true",
        help="--step takes states (B, 2n) and efforts (B, n) of a mechanism",
    )


def select_simulator(args: argparse.Namespace) -> Simulator | None:
    """Return the simulator of the command line, or None.

    Raises
    ------
    ValueError
        If there are parameters without `--step`.
    """
    if args.step is not None:
        return Simulator(args.step, tuple(args.parameter), args.vectorized)
    if args.parameter or args.vectorized:
        raise ValueError("--parameter, --vectorized: need --step FILE:NAME")
    return None


def load_function(text: str) -> Any:
    """Return the function of FILE:NAME. The file can import its neighbours."""
    file, _, name = text.rpartition(":")
    path = Path(file)
    if not file or not name.isidentifier():
        raise TrundleError(f"--step {text}: give FILE:NAME, such as simulator.py:step")
    if not path.is_file():
        raise TrundleError(f"--step {text}: the file {path} does not exist")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise TrundleError(f"--step {text}: {path} is not a Python file (.py)")
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(path.resolve().parent))
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise TrundleError(
            f"--step {text}: importing {path} raises {type(error).__name__}: {error}"
        ) from error
    finally:
        sys.path.pop(0)
    function = getattr(module, name, None)
    if not callable(function):
        raise TrundleError(f"--step {text}: {path} has no function {name!r}")
    return function


def parse_parameter(text: str) -> tuple[str, float | Sequence[float]]:
    """Return name and value of NAME=VALUE, or of NAME=START,LOWER,UPPER."""
    name, equals, given = text.partition("=")
    try:
        numbers = tuple(float(number) for number in given.split(","))
    except ValueError:
        numbers = ()
    if not name or not equals or len(numbers) not in (1, 3):
        raise TrundleError(f"--parameter {text}: give NAME=VALUE or NAME=START,LOWER,UPPER")
    return name, numbers[0] if len(numbers) == 1 else numbers
