"""`trundle run`: closed-loop episodes of the adaptive agent, with a page of their course."""

from __future__ import annotations

import argparse

from trundle.cli.options import add_config, add_out, add_quiet
from trundle.cli.paths import Output

HELP = "Run the adaptive agent in closed loop and write a page that shows its estimates after each push."
EXAMPLE = "trundle run configs/experiments/run.toml --out run"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the settings and the output folder."""
    add_config(parser, "settings, such as configs/experiments/run.toml")
    add_out(
        parser,
        "folder for histories, recordings and page.html; an interrupted run continues from it",
        Output("--out", "folder"),
        required=True,
    )
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Play what has not been played yet, and say how it ended."""
    from trundle.experiments.runs import run_closed_loop

    page = run_closed_loop(args.config, args.out, quiet=args.quiet, report=print)
    print(f"{page}: open it in a browser")
    return 0
