"""Arguments that several verbs share."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from trundle.cli.paths import Input, Output, declare

if TYPE_CHECKING:
    from trundle.experiments.backends import Backend
    from trundle.experiments.execution import Execution

__all__ = [
    "add_backend",
    "add_config",
    "add_execution",
    "add_mjcf",
    "add_model",
    "add_out",
    "add_prior",
    "add_quiet",
    "add_recording",
    "add_seed",
    "select_backend",
    "select_execution",
]


def add_config(parser: argparse.ArgumentParser, help: str, metavar: str = "CONFIG") -> None:
    """Add a settings file as the first argument: `args.config`, or the metavar in lower case."""
    parser.add_argument(metavar.lower(), metavar=metavar, type=Path, help=help)
    declare(parser, metavar.lower(), Input(metavar, "file", "a settings file (.toml)"))


def add_recording(parser: argparse.ArgumentParser, *, several: bool = False) -> None:
    """Add the input recording: `args.recording`, a path, or a list of paths if `several`."""
    text = "recording: a folder with recording.toml"
    if several:
        parser.add_argument("recording", metavar="RECORDING", type=Path, nargs="+", help=text)
    else:
        parser.add_argument("recording", metavar="RECORDING", type=Path, help=text)
    declare(parser, "recording", Input("RECORDING", "recording"))


def add_model(parser: argparse.ArgumentParser, *, required: bool = False) -> None:
    """Add `--model FILE`: `args.model`, a path or None."""
    parser.add_argument(
        "--model",
        metavar="FILE",
        type=Path,
        required=required,
        help="model.toml" if required else "model.toml (default: the paper's model)",
    )
    declare(parser, "model", Input("--model", "file", "a model file (model.toml)"))


def add_mjcf(parser: argparse.ArgumentParser, help: str) -> None:
    """Add `--mjcf FILE`: `args.mjcf`, a path or None."""
    parser.add_argument("--mjcf", metavar="FILE", type=Path, help=help)
    declare(parser, "mjcf", Input("--mjcf", "file", "an MJCF or URDF file"))


def add_prior(parser: argparse.ArgumentParser) -> None:
    """Add `--prior FILE`: `args.prior`, a path or None."""
    parser.add_argument(
        "--prior",
        metavar="FILE",
        type=Path,
        help="TOML file of priors by parameter, as in configs/priors/ (default: those that `trundle effects` "
        "lists)",
    )
    declare(parser, "prior", Input("--prior", "file", "a prior file, as in configs/priors/"))


def add_out(parser: argparse.ArgumentParser, help: str, output: Output, *, required: bool = False) -> None:
    """Add `--out PATH`: `args.out`, a path or None, which is checked before the work."""
    parser.add_argument("--out", metavar="PATH", type=Path, required=required, help=help)
    declare(parser, "out", output)


def add_seed(parser: argparse.ArgumentParser) -> None:
    """Add `--seed N`: `args.seed`, by default 0. The same input and seed give the same bytes."""
    parser.add_argument("--seed", metavar="N", type=_parse_seed, default=0, help="random seed (default 0)")


def add_quiet(parser: argparse.ArgumentParser) -> None:
    """Add `--quiet`: `args.quiet`. With it, only the result and errors are printed."""
    parser.add_argument("--quiet", action="store_true", help="do not print progress")


def add_backend(parser: argparse.ArgumentParser) -> None:
    """Add `--backend`, `--jobs` and `--address`, which `select_backend` reads."""
    parser.add_argument(
        "--backend",
        choices=("local", "joblib", "ray"),
        default="local",
        help="where jobs run: local processes (default), joblib, or a Ray cluster",
    )
    parser.add_argument(
        "--jobs",
        metavar="N",
        type=positive_int,
        help="number of processes (default 1; with Ray, all processors of the cluster)",
    )
    parser.add_argument(
        "--address",
        metavar="ADDRESS",
        help='address of a running Ray cluster, "auto" or "ray://host:10001" (default: start one here)',
    )


def select_backend(args: argparse.Namespace) -> Backend:
    """Return the backend selected by the arguments of `add_backend`."""
    from trundle.experiments.backends import backend

    return backend(args.backend, args.jobs, args.address)


def add_execution(parser: argparse.ArgumentParser, units: str, out: str, default: str) -> None:
    """Add the options that `select_execution` reads: the backend, the folders, and what is kept.

    Parameters
    ----------
    parser : ArgumentParser
    units : str
        The units of work, in words.
    out : str
        The output, in words.
    default : str
        Default of `--out`.
    """
    add_backend(parser)
    parser.add_argument(
        "--work",
        metavar="DIR",
        type=Path,
        help=f"folder of finished {units}, from which an interrupted run continues (default: in the system's "
        "temporary directory)",
    )
    parser.add_argument("--out", metavar="DIR", type=Path, help=f"folder for {out} (default {default})")
    declare(parser, "out", Output("--out", "folder", content=out))
    parser.add_argument("--fresh", action="store_true", help=f"discard finished {units}")
    parser.add_argument(
        "--redraw",
        action="store_true",
        help=f"write tables and figures from existing results, without new {units}",
    )
    add_quiet(parser)


def select_execution(args: argparse.Namespace, verb: str, out: Path) -> Execution:
    """Return the options of `add_execution`; `out` is the default folder."""
    from trundle.experiments.execution import Execution

    work = args.work or Path(tempfile.gettempdir()) / f"trundle-{verb}"
    backend = select_backend(args)
    return Execution(work, args.out or out, backend, args.fresh, args.redraw, args.quiet)


def positive_int(text: str) -> int:
    """Parse a positive integer."""
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive integer")
    return int(text)


def _parse_seed(text: str) -> int:
    try:
        seed = int(text)
    except ValueError:
        seed = -1
    if not 0 <= seed < 2**63:
        raise argparse.ArgumentTypeError(f"{text!r} is not an integer from 0 to 2**63 - 1")
    return seed
