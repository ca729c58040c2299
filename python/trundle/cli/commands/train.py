"""`trundle train`: agents of stable-baselines3, from a file."""

from __future__ import annotations

import argparse
import importlib.util
from pathlib import Path

from trundle.cli.options import add_backend, add_quiet, select_backend

HELP = "Train an agent of stable-baselines3 (extra: trundle[rl]); goes on where it was interrupted."
EXAMPLE = "trundle train configs/rl/ppo.toml --out trained --seed 1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the settings, the seeds and the folder."""
    parser.add_argument("config", metavar="CONFIG", type=Path, help="a file such as those of configs/rl")
    parser.add_argument(
        "--out",
        metavar="FOLDER",
        type=Path,
        required=True,
        help="folder of policies/, curves/, timing/ and, for checkpoints and TensorBoard, work/",
    )
    parser.add_argument(
        "--seed",
        metavar="N",
        type=int,
        action="append",
        help="train this seed alone; may be repeated (default: those of the file)",
    )
    add_backend(parser)
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Train the seeds, and print the result of each."""
    from trundle.experiments.backends import Local, in_order
    from trundle.experiments.training.config import read

    settings = read(args.config)
    chosen = select_seeds(args.seed, settings.seeds)
    if importlib.util.find_spec("stable_baselines3") is None:
        raise ValueError("`trundle train` needs stable-baselines3: pip install 'trundle[rl]'")
    from trundle.experiments.training.train import train_one

    where = select_backend(args)
    quiet = args.quiet or where != Local(1)  # one line of progress for several trainings says nothing
    for line in in_order(where, train_one, [(args.config, seed, args.out, quiet) for seed in chosen]):
        print(line, flush=True)
    return 0


def select_seeds(asked: list[int] | None, known: list[int]) -> list[int]:
    """Return the seeds to train; those asked for are among those of the file, fixed before any training."""
    for seed in asked or []:
        if seed not in known:
            raise ValueError(f"--seed {seed}: the file's seeds are {', '.join(map(str, known))}")
    return asked or known
