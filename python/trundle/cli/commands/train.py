"""`trundle train`: train agents and dynamics models, and search their settings."""

from __future__ import annotations

import argparse
from pathlib import Path

from trundle._optional import require
from trundle.cli.options import add_backend, add_config, add_quiet, select_backend
from trundle.cli.paths import Output, declare

HELP = "Train agents or dynamics models (needs trundle[rl]), or search settings; resume an interruption."
EXAMPLE = "trundle train configs/rl/ppo.toml --out trained --seed 1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the settings, the seeds and the output folder."""
    add_config(parser, "training settings, such as configs/rl/ppo.toml")
    parser.add_argument(
        "--out",
        metavar="FOLDER",
        type=Path,
        required=True,
        help="folder for policies/, dynamics/ or search/, curves/, timing/ and work/ (checkpoints and logs)",
    )
    declare(parser, "out", Output("--out", "folder"))
    parser.add_argument(
        "--seed",
        metavar="N",
        type=int,
        action="append",
        help="train only this seed; may be repeated (default: all seeds in CONFIG)",
    )
    parser.add_argument(
        "--search",
        action="store_true",
        help="run the random search of [search] in CONFIG on tuning worlds, and print its page",
    )
    parser.add_argument(
        "--device",
        default="cpu",
        help="device of PyTorch: cpu (default), cuda or auto; cpu gives the same bytes",
    )
    add_backend(parser)
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Train the selected seeds and print the result of each, or search and print the page."""
    if args.search:
        return run_search(args)
    from trundle.experiments.backends import Local, in_order
    from trundle.experiments.training.config import read

    settings = read(args.config)
    chosen = select_seeds(args.seed, settings.seeds)
    require("stable_baselines3", "rl", "trainings")
    require("sb3_contrib", "rl", "trainings")
    from trundle.experiments.training.train import train_one

    where = select_backend(args)
    quiet = args.quiet or where != Local(1)  # progress lines of parallel trainings would overlap
    for line in in_order(
        where, train_one, [(args.config, seed, args.out, quiet, args.device) for seed in chosen]
    ):
        print(line, flush=True)
    return 0


def run_search(args: argparse.Namespace) -> int:
    """Run a random search and print its page."""
    from trundle.experiments.execution import Execution
    from trundle.experiments.search.run import search

    if args.seed:
        raise ValueError("--seed: not allowed with --search; [search] in CONFIG has its own seed")
    execution = Execution(args.out / "work", args.out, select_backend(args), quiet=args.quiet)
    print(search(args.config, execution, args.device))
    return 0


def select_seeds(requested: list[int] | None, known: list[int]) -> list[int]:
    """Return the requested seeds, which must be among those of the settings, or else all of them."""
    for seed in requested or []:
        if seed not in known:
            raise ValueError(f"--seed {seed}: the seeds in CONFIG are {', '.join(map(str, known))}")
    return requested or known
