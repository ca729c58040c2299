"""`trundle simulate`: simulate a scenario and write a recording."""

from __future__ import annotations

import argparse
from pathlib import Path

from trundle.cli.options import add_out, add_seed
from trundle.cli.paths import RECORDING, Input, declare

HELP = "Simulate the pushes of a scenario and write the sensor readings as a recording."
EXAMPLE = "trundle simulate --demo --out demo/recording"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the scenario, `--demo`, `--out`, `--seed` and `--table`."""
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument(
        "scenario",
        metavar="SCENARIO",
        type=Path,
        nargs="?",
        help="scenario file, such as configs/experiments/demo.toml",
    )
    source.add_argument(
        "--demo",
        action="store_true",
        help="simulate the demo, which needs no file: a table with a locked wheel and hidden dry friction",
    )
    add_out(parser, "folder of the new recording", RECORDING, required=True)
    declare(parser, "scenario", Input("SCENARIO", "file", "a scenario file (.toml)"))
    add_seed(parser)
    parser.add_argument(
        "--table", choices=("csv", "parquet"), default="csv", help="format of the tables (default csv)"
    )


def run(args: argparse.Namespace) -> int:
    """Simulate the scenario, write the recording and print a summary."""
    import trundle

    recording = trundle.demo(args.seed) if args.demo else trundle.simulate(args.scenario, seed=args.seed)
    recording.write(args.out, table=args.table)
    held_out = len(recording.metadata.get("split", {}).get("held_out", []))
    print(f"{args.out}: {recording.name}, {len(recording.episodes)} episodes, {held_out} held out")
    return 0
