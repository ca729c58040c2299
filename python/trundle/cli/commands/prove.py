"""`trundle prove`: whether hidden effects are found, on recordings that other simulators made."""

from __future__ import annotations

import argparse
import importlib.util
import tempfile
from pathlib import Path

from trundle.cli.options import add_backend, add_quiet, select_backend

HELP = "Hide effects in recordings made with other simulators, diagnose them, and score the answers."
EXAMPLE = "trundle prove --config configs/experiments/proof_small.toml --jobs 2 --out proof"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the settings, what is done, and where things lie."""
    parser.add_argument(
        "--config",
        metavar="FILE",
        type=Path,
        default=Path("configs/experiments/proof.toml"),
        help="what is hidden and how often (default configs/experiments/proof.toml)",
    )
    parser.add_argument(
        "--range", metavar="NAME", default="report", help="range of seeds of the file (default report)"
    )
    add_backend(parser)
    parser.add_argument(
        "--work",
        metavar="DIR",
        type=Path,
        help="recordings while they are diagnosed; an interrupted proof goes on from it (default: in the "
        "system's temporary directory)",
    )
    parser.add_argument(
        "--out", metavar="DIR", type=Path, default=Path("docs"), help="folder of proof.md, proof/ and images/"
    )
    parser.add_argument("--limits", action="store_true", help="detection limits instead of the main proof")
    parser.add_argument(
        "--leave-one-out", action="store_true", help="diagnose again with the true effect left out"
    )
    parser.add_argument(
        "--after-design",
        action="store_true",
        help="where an answer says which push would tell, make it, and a random one; diagnose again",
    )
    parser.add_argument(
        "--shares",
        metavar="N",
        type=int,
        help="of a wide benchmark: do at most N shares that have no results yet (default: all)",
    )
    parser.add_argument("--fresh", action="store_true", help="forget drawn cases and results")
    parser.add_argument(
        "--redraw",
        action="store_true",
        help="no diagnosis: tables and figures from the results that are there",
    )
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Prove what was asked for and write the document."""
    if importlib.util.find_spec("mujoco") is None:
        raise ValueError("`trundle prove` makes its recordings with MuJoCo: pip install 'trundle[mujoco]'")
    if args.limits and args.after_design:
        raise ValueError("--after-design is of the main proof: leave out --limits")
    work = args.work or Path(tempfile.gettempdir()) / "trundle-prove"
    if is_wide(args.config):
        return run_wide(args, work)
    if args.shares is not None:
        raise ValueError(f"--shares is of a wide benchmark; {args.config} is not one")
    from trundle.experiments.blind.run import prove

    text = prove(
        args.config,
        args.range,
        work,
        args.out,
        backend=select_backend(args),
        limits=args.limits,
        leave_out=args.leave_one_out,
        after_design=args.after_design,
        fresh=args.fresh,
        redraw=args.redraw,
        quiet=args.quiet,
    )
    print(text)
    return 0


def is_wide(config: Path) -> bool:
    """Tell whether a file is that of a wide benchmark, by its `format`."""
    from trundle.experiments.wide.config import FORMAT
    from trundle.settings import parse

    return bool(parse(config).get("format") == FORMAT)


def run_wide(args: argparse.Namespace, work: Path) -> int:
    """Run a wide benchmark and write its page."""
    for option in ("limits", "leave_one_out", "after_design"):
        if getattr(args, option):
            raise ValueError(
                f"--{option.replace('_', '-')} is of the first benchmark; {args.config} is a wide one"
            )
    if args.shares is not None and args.shares < 1:
        raise ValueError(f"--shares {args.shares} must be at least 1")
    from trundle.experiments.wide.run import prove_wide

    text = prove_wide(
        args.config,
        args.range,
        work,
        args.out,
        backend=select_backend(args),
        shares=args.shares,
        fresh=args.fresh,
        redraw=args.redraw,
        quiet=args.quiet,
    )
    print(text)
    return 0
