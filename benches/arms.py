"""Success of the adaptive agent with real arms, with and without the estimate of the arm.

python benches/arms.py --episodes 40 --jobs 2 --out arms.csv

Each cell of the table is an arm. The same worlds (the training set of a level, with seeds for tuning) are
pushed around an obstacle by the agent with the default settings and with `arm = False`. A success reaches the
goal without touching the obstacle. The last column counts the worlds in which only one of the two succeeds.
Decision times are CPU times of one process on one thread.
"""

from __future__ import annotations

import argparse
import csv
import os
import warnings
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path
from time import process_time
from typing import Any, NamedTuple

os.environ.setdefault("RAYON_NUM_THREADS", "1")

import gymnasium
import numpy as np

import trundle
from trundle.atomic import atomic_file

ARMS: dict[str, dict[str, Any]] = {
    "ideal": {},
    "lag 80 ms": {"arm": {"lag": 0.08}},
    "lag 150 ms": {"arm": {"lag": 0.15}},
    "delay 100 ms": {"arm": {"delay": 0.1}},
    "sensor delay 100 ms": {"sensor_delay": 0.1},
    "soft wrist": {"arm": {"wrist": {}}},
    "decision time 50 ms": {"realtime": 0.05},
    "lag 80 ms, all delays 50 ms": {
        "arm": {"lag": 0.08, "delay": 0.05},
        "sensor_delay": 0.05,
        "realtime": 0.05,
    },
}
"""Arguments of the environment."""


class Outcome(NamedTuple):
    """Outcome of an episode; times in s."""

    arm: str
    estimated: bool
    seed: int
    success: bool
    reached: bool
    contact: float
    reward: float
    seconds: float
    median: float
    percentile_99: float
    longest: float
    estimate: str


def play(task: str, arm: str, estimated: bool, seed: int) -> Outcome:
    """Run an episode."""
    warnings.filterwarnings("ignore", category=DeprecationWarning)
    env = gymnasium.make(task, hidden="locked", **ARMS[arm])
    observation, info = env.reset(seed=seed)
    agent = trundle.AdaptiveAgent(env, trundle.AgentSettings(arm=estimated))
    over, reward, times = False, 0.0, list[float]()
    while not over:
        began = process_time()
        action, (belief,) = agent.predict(observation, episode_start=not times)
        times.append(process_time() - began)
        observation, gained, terminated, truncated, info = env.step(action)
        reward, over = reward + float(gained), terminated or truncated
    source: Any = env.unwrapped
    return Outcome(
        arm=arm,
        estimated=estimated,
        seed=seed,
        success=bool(info["success_without_touching"]),
        reached=bool(info["is_success"]),
        contact=float(info["contact_time"]),
        reward=reward,
        seconds=source.control * len(times),
        median=float(np.median(times)),
        percentile_99=float(np.quantile(times, 0.99)),
        longest=max(times),
        estimate=repr(belief.arm),
    )


def table(outcomes: list[Outcome], arms: list[str]) -> str:
    """Return the outcomes as a Markdown table."""
    lines = [
        "| arm | without | with | only with : only without | decision: median, 99 %, longest |",
        "| --- | --- | --- | --- | --- |",
    ]
    for arm in arms:
        without, estimated = (
            [o for o in outcomes if o.arm == arm and o.estimated == e] for e in (False, True)
        )
        gained = sum(b.success and not a.success for a, b in zip(without, estimated, strict=True))
        lost = sum(a.success and not b.success for a, b in zip(without, estimated, strict=True))
        rates = " | ".join(
            f"{sum(o.success for o in group)} of {len(group)}" for group in (without, estimated)
        )
        times = (
            float(np.median([o.median for o in estimated])),
            float(np.median([o.percentile_99 for o in estimated])),
            max(o.longest for o in estimated),
        )
        spent = ", ".join(f"{1e3 * time:.0f}" for time in times)
        lines.append(f"| {arm} | {rates} | {gained} : {lost} | {spent} ms |")
    return "\n".join(lines)


def main() -> None:
    """Run all episodes and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--task", default="trundle/PushAroundMedium-v1", help="id of the environment")
    parser.add_argument("--arms", nargs="+", choices=ARMS, default=list(ARMS), help="cells of the table")
    parser.add_argument("--first", type=int, default=5000, help="first seed; below 10000 for tuning")
    parser.add_argument("--episodes", type=int, default=40, help="episodes per cell")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--out", type=Path, help="CSV file of all episodes")
    args = parser.parse_args()
    seeds = range(args.first, args.first + args.episodes)
    jobs = list(product([args.task], args.arms, [False, True], seeds))
    with ProcessPoolExecutor(args.jobs) as pool:
        outcomes = list(pool.map(play, *zip(*jobs, strict=True)))
    if args.out:
        with atomic_file(args.out) as part, part.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(Outcome._fields)
            writer.writerows(outcomes)
    print(table(outcomes, args.arms))


if __name__ == "__main__":
    main()
