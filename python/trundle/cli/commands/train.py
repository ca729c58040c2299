"""`trundle train`: agents of stable-baselines3, from a file."""

from __future__ import annotations

import argparse
import importlib.util
from pathlib import Path

from trundle.cli.options import add_quiet
from trundle.cli.progress import Progress

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
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Train one seed after the other, and say what each came to."""
    from trundle.learning.config import read

    settings = read(args.config)
    chosen = seeds(args.seed, settings.seeds)
    if importlib.util.find_spec("stable_baselines3") is None:
        raise ValueError("`trundle train` needs stable-baselines3: pip install 'trundle[rl]'")
    from trundle.learning.train import Training

    for seed in chosen:
        training = Training(settings, seed, args.out)
        with Progress("training", quiet=args.quiet) as progress:
            told = training.run(progress.show)
        last, rises = told["curve"][-1], "" if told["flattened"] else "; the curve still rises"
        print(
            f"{training.policy_file}: success {last['success']:.0%}, {last['distance']:.2f} m off after "
            f"{told['steps']:,} steps, {told['simulated_seconds']:,.0f} s of pushing{rises}"
        )
    return 0


def seeds(asked: list[int] | None, known: list[int]) -> list[int]:
    """Return the seeds to train; those asked for are among those of the file, fixed before any training."""
    for seed in asked or []:
        if seed not in known:
            raise ValueError(f"--seed {seed}: the file's seeds are {', '.join(map(str, known))}")
    return asked or known
