"""`trundle calibrate`: simulation-based calibration of posterior intervals."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from trundle._optional import require
from trundle._types import CalibrationTable
from trundle.cli.options import add_backend, add_config, add_out, add_quiet, add_seed, select_backend
from trundle.cli.paths import Output, declare
from trundle.progress import Progress

HELP = "Check the coverage of posterior intervals: draw parameters, simulate, infer, count."
EXAMPLE = "trundle calibrate configs/experiments/calibrate.toml --replicates 200 --out calibration.jsonl"

ACCEPTED_COVERAGE = (0.85, 0.95)
"""Range in which the coverage of 90 % intervals is reported as correct."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the configuration, the number of rounds, the method and the output files."""
    add_config(parser, "calibration settings, such as configs/experiments/calibrate.toml")
    parser.add_argument(
        "--replicates", metavar="N", type=int, default=200, help="number of rounds (default 200)"
    )
    parser.add_argument(
        "--method", choices=("nuts", "laplace", "metropolis"), help="sampler (default: that of CONFIG)"
    )
    add_out(
        parser, "JSON lines file of the rounds; an interrupted run continues from it", Output("--out", "file")
    )
    parser.add_argument(
        "--figure", metavar="FILE", type=Path, help="PNG or SVG file for the histograms of ranks"
    )
    declare(parser, "figure", Output("--figure", "file", (".png", ".svg", ".pdf"), content="a figure"))
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    add_backend(parser)
    add_seed(parser)
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Run the calibration, print the table and draw the figure."""
    from trundle.calibration import calibrate

    if args.figure is not None:
        require("matplotlib", "plots", "plots")  # before hours of calibration
    with Progress(f"calibrating {args.config}", quiet=args.quiet) as progress:
        found = calibrate(
            args.config,
            replicates=args.replicates,
            method=args.method,
            seed=args.seed,
            out=args.out,
            backend=select_backend(args),
            progress=progress.share,
        )
    if args.figure is not None:
        found.figure(args.figure)
    print(json.dumps(found.table, indent=2, ensure_ascii=False) if args.json else format_table(found.table))
    return 0


def format_table(found: CalibrationTable) -> str:
    """Format a calibration for the terminal."""
    lines = found["parameters"]
    rows = [f"{found['name']}, {found['method']}, {lines[0]['rounds']} rounds"]
    rows.append(f"  {'':28}{'50 % covers':>22}{'90 % covers':>22}{'uniform, p':>12}")
    for line in lines:
        covers = "".join(f"{format_share(cover):>22}" for cover in (line["cover_50"], line["cover_90"]))
        rows.append(f"  {line['name']:28}{covers}{line['uniform_p']:12.3g}")
    low, high = ACCEPTED_COVERAGE
    off = [line["name"] for line in lines if not low <= line["cover_90"][0] <= high]
    verdict = (
        f"outside {low:.0%} to {high:.0%} for {', '.join(off)}"
        if off
        else f"within {low:.0%} to {high:.0%} for all parameters"
    )
    return "\n".join([*rows, f"  coverage of the 90 % intervals: {verdict}"])


def format_share(cover: list[float]) -> str:
    """Format a share with its 95 % interval."""
    return f"{cover[0]:.1%} ({cover[1]:.0%} to {cover[2]:.0%})"
