"""`trundle paper`: the experiments of section V of the paper, and two more."""

from __future__ import annotations

import argparse
from pathlib import Path

from trundle._optional import require
from trundle.cli.options import add_execution, positive_int, select_execution

HELP = "Run an experiment of the paper and write its table and figures to paper.md."
EXAMPLE = "trundle paper fig6 --quick"

DEFAULT_OUT = "paper"
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
        "--quick", action="store_true", help="run a small version and write to paper-quick/ instead of paper/"
    )
    parser.add_argument(
        "--configs",
        metavar="DIR",
        type=Path,
        default=Path("configs"),
        help="folder with experiments/ and objects/ (default configs)",
    )
    add_execution(parser, "trials", "paper.md, paper/ (results) and images/", DEFAULT_OUT)


def run(args: argparse.Namespace) -> int:
    """Run the selected experiments in turn."""
    for module in ("matplotlib", "pandas", "pyarrow", "scipy"):
        require(module, "experiments", "experiments of the paper")
    from trundle.experiments.paper.run import run_one

    execution = select_execution(args, "paper", Path("paper-quick" if args.quick else DEFAULT_OUT))
    for name in CHOICES[1:] if args.experiment == "all" else [args.experiment]:
        print(run_one(name, args.configs, execution, seeds=args.seeds, quick=args.quick))
    return 0
