"""Steps per CPU second of the environments and of peers, the overhead of a step, and memory.

python benches/environment.py --rounds 9

A step is an action of 20 ms: 10 simulation steps of 2 ms in trundle and MuJoCo; other peers have their own
steps. Each uses one thread. All take turns, and the fastest turn of each counts. `peers.py` describes the
peers. trundle's environments include noise, rewards and resets; MuJoCo's tables are physics only. "x same"
and "x lean" are ratios to the fastest way of stepping MuJoCo's table of that law in the same scene, "x pusht"
to gym-pusht. `mixed_episodes.py` describes the episodes with obstacles, resets and ordinary actions that
follow; `--mix` measures them alone.
"""

from __future__ import annotations

import argparse
import gc
import os
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from time import process_time
from typing import Any

import gymnasium
import mixed_episodes
import numpy as np
from peers import (
    FREE,
    GRIPPER,
    LAWS,
    MANY,
    OWN,
    PRESS,
    PUSHT,
    SCENES,
    STEP,
    SUBSTEPS,
    WALL,
    Contestant,
    others,
)

import trundle
from trundle.envs import Observation

ENVS = (1, 64, MANY)
TURN_DURATION_S = 0.15
"""Duration of a turn, CPU s."""
ACTION_LENGTHS = (1, 10, 25, 50)
"""Numbers of simulation steps per action, from which the cost of an action without any is extrapolated."""
TASKS = {FREE: "LockedWheel", WALL: "PushDoor", GRIPPER: "LockedWheel"}
TARGET_RATIOS = {FREE: 10.0, WALL: 1.2, GRIPPER: 1.2}
"""Target ratios to the speed of MuJoCo."""
PUSHT_TARGET_RATIO = 100.0
"""Target ratio to the speed of gym-pusht, away from obstacles."""
MAX_MEMORY_KIB = 64.0
"""Target for the memory of an environment, KiB."""
WALL_DISTANCE_M = 0.05 + 0.6 + 0.004
"""Distance from the middle of a wall to that of a table in front of it, with a gap of 4 mm, m."""


def environment_options(scene: str, substeps: int = SUBSTEPS) -> dict[str, Any]:
    """Return the arguments of an environment; episodes end only if the object leaves the workspace."""
    action = "velocity" if scene == GRIPPER else "wrench"
    return {"action": action, "hidden": "locked", "step": STEP, "substeps": substeps, "horizon": 0}


def options_at_wall() -> dict[str, Any]:
    """Return reset options that place the table of seed 0 in front of a wall next to the doorway."""
    seen = Observation(gymnasium.make("trundle/PushDoor-v0", **environment_options(WALL)).reset(seed=0)[0])
    (x, y), (cos, sin) = seen.door_position, seen.door_direction
    offset = seen.door_width / 2 + 0.45
    return {
        "start": [
            x - WALL_DISTANCE_M * cos - offset * sin,
            y - WALL_DISTANCE_M * sin + offset * cos,
            np.arctan2(sin, cos),
        ]
    }


def actions(scene: str, envs: int) -> list[Any]:
    """Return a cycle of actions: a push against the wall, or random wrenches or velocities."""
    if scene == WALL:
        return [np.tile(np.float32([PRESS, 0.0, 0.0]), (envs, 1))]
    drawn = np.random.default_rng(0).uniform(-1.0, 1.0, (32, envs, 3)).astype(np.float32)
    return list(0.3 * drawn if scene == FREE else np.concatenate([drawn, -drawn]))


def single(scene: str, substeps: int = SUBSTEPS) -> Contestant:
    """Return a single environment of trundle."""
    env: Any = gymnasium.make(f"trundle/{TASKS[scene]}-v0", **environment_options(scene, substeps)).unwrapped
    env.reset(seed=0, options=options_at_wall() if scene == WALL else None)
    cycle, touched = [action[0] for action in actions(scene, 1)], [False]

    def act(calls: int) -> None:
        for k in range(calls):
            _, _, terminated, _, info = env.step(cycle[k % len(cycle)])
            if terminated:
                env.reset()
        touched[0] = info["touched"]

    return Contestant("trundle single", scene, 1, act, lambda: f"touched {touched[0]}")


def vector(scene: str, envs: int, substeps: int = SUBSTEPS) -> Contestant:
    """Return a batch of trundle. At a wall all environments have the same seed, hence the same wall."""
    known = environment_options(scene, substeps)
    env: Any = gymnasium.make_vec(f"trundle/{TASKS[scene]}-v0", num_envs=envs, copy=False, **known)
    at_wall = scene == WALL
    env.reset(seed=[0] * envs if at_wall else 0, options=options_at_wall() if at_wall else None)
    cycle, touched = actions(scene, envs), [0]

    def act(calls: int) -> None:
        for k in range(calls):
            infos = env.step(cycle[k % len(cycle)])[-1]
        touched[0] = infos["touched"].sum()

    return Contestant(f"trundle make_vec {envs}", scene, envs, act, lambda: f"touched {touched[0]} of {envs}")


def step_time(one: Contestant, calls: int) -> float:
    """Return the CPU time of one environment step, s."""
    start = process_time()
    one.act(calls)
    return (process_time() - start) / (calls * one.envs)


def step_times(contestants: Iterable[Contestant], rounds: int) -> dict[Contestant, float]:
    """Return the CPU time of a step, s: the minimum over `rounds` turns."""
    calls: dict[Contestant, int] = {}
    for one in contestants:
        one.act(1 + 200 // one.envs if one.scene != WALL else 100)
        calls[one] = max(1, round(TURN_DURATION_S / (step_time(one, 1 + 100 // one.envs) * one.envs)))
    turns = [[step_time(one, count) for one, count in calls.items()] for _ in range(rounds)]
    return dict(zip(calls, np.min(turns, axis=0).tolist(), strict=True))


def trundle_contestants() -> Iterator[Contestant]:
    """Yield the environments of trundle."""
    for scene in SCENES:
        yield single(scene)
        yield from (vector(scene, envs) for envs in ENVS)


def shortest_step(durations: dict[Contestant, float], scene: str, name: str) -> float:
    """Return the shortest step in a scene among contestants whose names start with `name`, s."""
    times = (
        duration for one, duration in durations.items() if one.scene == scene and one.name.startswith(name)
    )
    return min(times, default=np.nan)


def print_times(durations: dict[Contestant, float]) -> None:
    """Print times and ratios by scene."""
    print(f"{'':36}{'':>7}{'steps per':>11}{'ns per':>9}")
    print(f"{'':36}{'envs':>7}{'CPU second':>11}{'step':>9}{'x same':>9}{'x lean':>9}{'x pusht':>9}")
    pusht = shortest_step(durations, OWN, PUSHT)
    for scene in (*SCENES, OWN):
        print(scene)
        peers = (*(shortest_step(durations, scene, f"MuJoCo {law}") for law in LAWS), pusht)
        for one, duration in ((one, duration) for one, duration in durations.items() if one.scene == scene):
            ratios = "".join(f"{peer / duration:9.2f}".replace("nan", "  -") for peer in peers)
            touching = f"  {one.touching()}" if scene == WALL else ""
            print(f"  {one.name:34}{one.envs:7}{1 / duration:11,.0f}{1e9 * duration:9,.0f}{ratios}{touching}")


def print_targets(durations: dict[Contestant, float]) -> None:
    """Print whether the fastest of trundle's environments reach the targets."""
    print("\nratio of the fastest of trundle to the fastest peer")
    pairs = [(scene, scene, f"MuJoCo {law}", ratio) for scene, ratio in TARGET_RATIOS.items() for law in LAWS]
    for scene, where, name, target in [*pairs, (FREE, OWN, PUSHT, PUSHT_TARGET_RATIO)]:
        ratio = shortest_step(durations, where, name) / shortest_step(durations, scene, "trundle")
        print(f"  {scene + ', ' + name:42}{ratio:9.2f}  {verdict(ratio, target)}")


def verdict(ratio: float, target: float) -> str:
    if np.isnan(ratio):
        return "not measured"
    return f"{'reached' if ratio >= target else 'missed'}: {target:g}"


def print_overhead(rounds: int) -> None:
    """Print the overhead of a step: the intercept of the time over the number of simulation steps."""
    heads = "".join(f"{head:>9}" for head in (*ACTION_LENGTHS, "per step", "overhead"))
    print(f"\n{'ns by simulation steps per action':42}{heads}")
    for scene in SCENES:
        kinds = [[single(scene, n) for n in ACTION_LENGTHS], [vector(scene, MANY, n) for n in ACTION_LENGTHS]]
        durations = step_times([one for kind in kinds for one in kind], rounds)
        for kind in kinds:
            times = np.array([1e9 * durations[one] for one in kind])
            # The error is proportional to the time.
            line = np.polyfit(ACTION_LENGTHS, times, 1, w=1 / times)
            row = "".join(f"{value:9,.0f}" for value in (*times, *line))
            print(f"  {kind[0].name + ', ' + scene:40}{row}")


def resident_memory_kib() -> float:
    """Return the resident memory of this process, KiB (Linux)."""
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1024


def memory_per_environment(scene: str) -> float:
    """Return the memory of an environment without shared data, KiB."""
    vector(scene, 1).act(100)
    before = resident_memory_kib()
    many = vector(scene, MANY)
    many.act(100 if scene == WALL else 1)
    if scene == WALL and many.touching() != f"touched {MANY} of {MANY}":
        raise RuntimeError(f"some environments are not at the wall: {many.touching()}")
    return (resident_memory_kib() - before) / MANY


def print_memory() -> None:
    """Print the memory of environments, each measured in a separate process."""
    print(f"\nKiB per environment, in a batch of {MANY}")
    for scene, name in ((FREE, "at rest"), (WALL, "all at a wall")):
        command = [sys.executable, __file__, "--growth", scene]
        taken = float(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
        result = "reached" if taken < MAX_MEMORY_KIB else "missed"
        print(f"  {name:42}{taken:9.1f}  {result}: {MAX_MEMORY_KIB:g}")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--rounds", type=int, default=9, help="turns of each contestant (default 9)")
    parser.add_argument("--mix", action="store_true", help="only the episodes with obstacles")
    parser.add_argument("--growth", choices=SCENES, help=argparse.SUPPRESS)
    args = parser.parse_args()
    os.environ.setdefault("RAYON_NUM_THREADS", "1")
    if args.growth:
        print(memory_per_environment(args.growth))
        return
    print(f"trundle {trundle.__version__}, {' '.join(os.uname())}")
    if args.mix:
        mixed_episodes.print_mix(args.rounds)
        return
    durations = step_times([*trundle_contestants(), *others()], args.rounds)
    print_times(durations)
    print_targets(durations)
    print_overhead(args.rounds)
    print_memory()
    mixed_episodes.print_mix(args.rounds)


if __name__ == "__main__":
    main()
