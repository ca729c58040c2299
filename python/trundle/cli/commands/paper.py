"""`trundle paper`: the experiments of the paper's section V, and two more."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from trundle.cli.options import add_backend, add_quiet, select_backend

HELP = "Run an experiment of the paper and write its table and figures into docs/paper.md."
EXAMPLE = "trundle paper fig6 --quick"

CHOICES = ("all", "fig5", "fig6", "fig8", "open-loop", "wheel")
"""Not taken from `trundle.experiments.paper`, which is slow to import; a test holds the two together."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the experiment, its size, and where things lie."""
    parser.add_argument("experiment", choices=CHOICES, help="which; all: one after the other")
    parser.add_argument(
        "--seeds", metavar="N", type=int, help="seeds; as the experiment's file says if left out"
    )
    parser.add_argument(
        "--quick", action="store_true", help="a small version; goes to paper-quick/, not docs/"
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        help="folder of paper.md, paper/ (results) and images/ (default docs)",
    )
    parser.add_argument(
        "--configs",
        metavar="DIR",
        type=Path,
        default=Path("configs"),
        help="folder of experiments/ and objects/",
    )
    add_backend(parser)
    parser.add_argument(
        "--work",
        metavar="DIR",
        type=Path,
        help="trials as they end; an interrupted experiment continues from them (default: in the system's "
        "temporary directory)",
    )
    parser.add_argument("--fresh", action="store_true", help="forget the trials that were run")
    parser.add_argument(
        "--redraw",
        action="store_true",
        help="no trial at all: tables and figures from the results that are there",
    )
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Run what was asked for, one after the other."""
    from trundle.experiments.paper.experiment import Options
    from trundle.experiments.paper.run import run_one

    out = args.out or Path("paper-quick" if args.quick else "docs")
    options = Options(args.configs, args.seeds, args.quick)
    work = args.work or Path(tempfile.gettempdir()) / "trundle-paper"
    for name in CHOICES[1:] if args.experiment == "all" else [args.experiment]:
        text = run_one(
            name,
            options,
            work,
            out,
            backend=select_backend(args),
            fresh=args.fresh,
            redraw=args.redraw,
            quiet=args.quiet,
        )
        print(text)
    return 0
