"""`trundle prove`: blind benchmark on recordings with hidden effects, made with other simulators."""

from __future__ import annotations

import argparse
from pathlib import Path

from trundle._optional import require
from trundle.cli.options import add_backend, add_quiet, select_execution
from trundle.cli.paths import Input, Output, declare

HELP = "Run a blind benchmark: hide effects in recordings of other simulators, diagnose, and score."
EXAMPLE = "trundle prove --config configs/experiments/proof_small.toml --jobs 2 --out proof"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the settings, the variant of the benchmark and the folders."""
    parser.add_argument(
        "--config",
        metavar="FILE",
        type=Path,
        default=Path("configs/experiments/proof.toml"),
        help="settings of the benchmark (default configs/experiments/proof.toml)",
    )
    declare(parser, "config", Input("--config", "file", "a settings file (.toml)"))
    parser.add_argument(
        "--range", metavar="NAME", default="report", help="range of seeds in the settings (default report)"
    )
    add_backend(parser)
    parser.add_argument(
        "--work",
        metavar="DIR",
        type=Path,
        help="folder of recordings and results, from which an interrupted benchmark continues "
        "(default: in the temporary directory of the system)",
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        default=Path("proof"),
        help="folder of the page, of its results and of images/ (default proof)",
    )
    declare(parser, "out", Output("--out", "folder"))
    parser.add_argument(
        "--limits", action="store_true", help="measure detection limits instead of the main benchmark"
    )
    parser.add_argument(
        "--leave-one-out",
        action="store_true",
        help="also diagnose with the true effect removed from the catalogue",
    )
    parser.add_argument(
        "--after-design",
        action="store_true",
        help="simulate the discriminating push that a diagnosis designs, and a random push; diagnose again",
    )
    parser.add_argument(
        "--shares",
        metavar="N",
        type=int,
        help="for a wide benchmark: run at most N shares that have no results yet (default: all)",
    )
    parser.add_argument("--fresh", action="store_true", help="discard drawn cases and results")
    parser.add_argument(
        "--redraw",
        action="store_true",
        help="write tables and figures from existing results, without new diagnoses",
    )
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Run the selected benchmark and write its document."""
    for module in ("matplotlib", "mujoco", "scipy"):
        require(module, "experiments", "blind benchmarks")
    from trundle.experiments.blind.run import prove

    text = prove(
        args.config,
        args.range,
        select_execution(args, "prove", args.out),
        limits=args.limits,
        leave_out=args.leave_one_out,
        after_design=args.after_design,
        shares=args.shares,
    )
    print(text)
    return 0
