"""Compare agents on gym-pusht with hidden mass, floor friction and centre of mass: docs/arena.md.

    pip install 'trundle[arena]'
    python examples/arena.py --out docs
    python examples/arena.py --out docs --train 150000   # with PPO; needs trundle[rl] too

Finished episodes are kept in the folder of --work: an interrupted command continues.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from trundle.experiments.arena.agents import AGENTS
from trundle.experiments.arena.probe import probes
from trundle.experiments.arena.run import summary, tournament
from trundle.experiments.arena.training import train
from trundle.experiments.arena.world import PHYSICS
from trundle.experiments.backends import Local
from trundle.experiments.markdown import replace_section
from trundle.experiments.results import write_lines

SECTIONS = ["arena probe", *(f"arena {physics}" for physics in PHYSICS)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--worlds", type=int, default=32, help="number of hidden worlds (32)")
    parser.add_argument("--seed", type=int, default=1000, help="seed of the first world (1000)")
    parser.add_argument("--physics", choices=PHYSICS, nargs="+", default=PHYSICS)
    parser.add_argument("--agents", choices=AGENTS, nargs="+", help="all, ppo only with a policy")
    parser.add_argument("--train", type=int, metavar="STEPS", help="train the missing policies first")
    parser.add_argument("--jobs", type=int, default=1, help="processes (1)")
    parser.add_argument("--work", type=Path, default=Path("arena"), help="episodes, policies (arena)")
    parser.add_argument("--out", type=Path, default=Path("arena"), help="arena.md and arena/ (arena)")
    options = parser.parse_args()
    replace_section(options.out / "arena.md", "arena probe", probes(), SECTIONS, "")
    for physics in options.physics:
        policy = options.work / f"ppo-{physics}.zip"
        if options.train and not policy.exists():
            train(physics, options.train, 0, policy)
        agents = options.agents or [name for name in AGENTS if name != "ppo" or policy.exists()]
        seeds = range(options.seed, options.seed + options.worlds)
        rows = tournament(physics, agents, seeds, options.work, Local(options.jobs))
        write_lines(options.out / "arena" / f"{physics}.jsonl", rows)
        replace_section(options.out / "arena.md", f"arena {physics}", summary(rows), SECTIONS, "")
        print(f"{physics}\n\n{summary(rows)}\n", flush=True)


if __name__ == "__main__":
    main()
