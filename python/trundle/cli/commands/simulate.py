"""`trundle simulate`: a recording from a scenario."""

from __future__ import annotations

import argparse
from pathlib import Path

from trundle.cli.options import add_out, add_seed

HELP = "Simulate the pushes of a scenario and write what the instruments saw as a recording."
EXAMPLE = "trundle simulate configs/experiments/demo.toml --out demo/recording"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the scenario, `--out`, `--seed` and `--table`."""
    parser.add_argument(
        "scenario", metavar="SCENARIO", type=Path, help="a scenario, as those in configs/experiments"
    )
    add_out(parser, "the recording's folder", required=True)
    add_seed(parser)
    parser.add_argument("--table", choices=("csv", "parquet"), default="csv", help="form of the tables")


def run(args: argparse.Namespace) -> int:
    """Simulate, write, and say what was written."""
    import trundle

    recording = trundle.simulate(args.scenario, seed=args.seed)
    recording.write(args.out, table=args.table)
    held_out = len(recording.metadata.get("split", {}).get("held_out", []))
    print(f"{args.out}: {recording.name}, {len(recording.episodes)} episodes, {held_out} held out")
    return 0
