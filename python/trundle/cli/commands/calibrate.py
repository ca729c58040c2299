"""`trundle calibrate`: whether intervals cover as often as they say."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from trundle.cli.options import add_backend, add_out, add_quiet, add_seed, select_backend
from trundle.cli.progress import Progress

HELP = "Draw parameters, simulate, infer, and count how often the intervals cover the truth."
EXAMPLE = "trundle calibrate configs/experiments/calibrate.toml --replicates 200 --out calibration.jsonl"

ACCEPTED_COVERAGE = (0.85, 0.95)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the configuration, the rounds, the method and where to write."""
    parser.add_argument(
        "config", metavar="CONFIG", type=Path, help="a calibration, as configs/experiments/calibrate.toml"
    )
    parser.add_argument("--replicates", metavar="N", type=int, default=200, help="rounds (default 200)")
    parser.add_argument("--method", choices=("nuts", "laplace", "metropolis"), help="in place of the file's")
    add_out(parser, "JSON lines of the rounds; an interrupted run goes on from it")
    parser.add_argument("--figure", metavar="FILE", type=Path, help="PNG or SVG of the ranks to draw")
    parser.add_argument("--json", action="store_true", help="print the result for programs")
    add_backend(parser)
    add_seed(parser)
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Calibrate, print the table, and draw the figure."""
    from trundle.calibration import calibrate

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


def format_table(found: dict[str, Any]) -> str:
    """Return the calibration for a terminal."""
    lines = found["parameters"]
    rows = [f"{found['name']}, {found['method']}, {lines[0]['rounds']} rounds"]
    rows.append(f"  {'':28}{'50 % covers':>22}{'90 % covers':>22}{'uniform, p':>12}")
    for line in lines:
        covers = "".join(f"{format_share(line[key]):>22}" for key in ("cover_50", "cover_90"))
        rows.append(f"  {line['name']:28}{covers}{line['uniform_p']:12.3g}")
    low, high = ACCEPTED_COVERAGE
    off = [line["name"] for line in lines if not low <= line["cover_90"][0] <= high]
    verdict = (
        f"outside of {low:.0%} to {high:.0%}: {', '.join(off)}"
        if off
        else f"all within {low:.0%} to {high:.0%}"
    )
    return "\n".join([*rows, f"  coverage of the 90 % intervals {verdict}"])


def format_share(cover: list[float]) -> str:
    """Return a share with its 95 % interval."""
    return f"{cover[0]:.1%} ({cover[1]:.0%} to {cover[2]:.0%})"
