"""`trundle paper`: the experiments of section V of the paper, and two more."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from trundle.cli.options import add_backend, add_quiet, positive_int, select_backend

HELP = "Run an experiment of the paper and write its table and figures to docs/paper.md."
EXAMPLE = "trundle paper fig6 --quick"

CHOICES = ("all", "fig5", "fig6", "fig8", "open-loop", "wheel")
"""Experiments. Repeated here because `trundle.experiments.paper` is slow to import; a test compares them."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the experiment, its size and the folders."""
    parser.add_argument("experiment", choices=CHOICES, help="experiment to run; all: every one in turn")
    parser.add_argument(
        "--seeds",
        metavar="N",
        type=positive_int,
        help="number of seeds (default: as in the experiment's settings)",
    )
    parser.add_argument(
        "--quick", action="store_true", help="run a small version and write to paper-quick/ instead of docs/"
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        help="folder for paper.md, paper/ (results) and images/ (default docs)",
    )
    parser.add_argument(
        "--configs",
        metavar="DIR",
        type=Path,
        default=Path("configs"),
        help="folder with experiments/ and objects/ (default configs)",
    )
    add_backend(parser)
    parser.add_argument(
        "--work",
        metavar="DIR",
        type=Path,
        help="folder of finished trials, from which an interrupted experiment continues (default: in the "
        "temporary directory of the system)",
    )
    parser.add_argument("--fresh", action="store_true", help="discard finished trials")
    parser.add_argument(
        "--redraw",
        action="store_true",
        help="write tables and figures from existing results, without new trials",
    )
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Run the selected experiments in turn."""
    from trundle.experiments.paper.run import run_one

    out = args.out or Path("paper-quick" if args.quick else "docs")
    work = args.work or Path(tempfile.gettempdir()) / "trundle-paper"
    for name in CHOICES[1:] if args.experiment == "all" else [args.experiment]:
        text = run_one(
            name,
            args.configs,
            work,
            out,
            backend=select_backend(args),
            seeds=args.seeds,
            quick=args.quick,
            fresh=args.fresh,
            redraw=args.redraw,
            quiet=args.quiet,
        )
        print(text)
    return 0
