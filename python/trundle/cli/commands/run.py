"""`trundle run`: episodes in closed loop, as they go, and as a page."""

from __future__ import annotations

import argparse
from pathlib import Path

from trundle.cli.options import add_out, add_quiet

HELP = (
    "Let the adaptive agent push to a goal and learn on the way; a page shows what it believed, push by push."
)
EXAMPLE = "trundle run configs/experiments/run.toml --out run"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is run and where it is kept."""
    parser.add_argument(
        "config", metavar="CONFIG", type=Path, help="what is to be run, as configs/experiments/run.toml"
    )
    add_out(
        parser,
        "folder of histories, recordings and page.html; a run that was interrupted goes on from it",
        required=True,
    )
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Play what has not been played yet, and say how it ended."""
    from trundle.experiments.runs import run_closed_loop

    page = run_closed_loop(args.config, args.out, quiet=args.quiet, tell=print)
    print(f"{page}: open it in a browser")
    return 0
