"""Steps per CPU-second of the environments beside others', what a step costs beside physics, and memory.

python benches/environment.py --rounds 9

A step is an action of 20 ms: 10 simulation steps of 2 ms, here and in MuJoCo; the others have their own. One
thread each. All take turns; the fastest turn of each counts. `peers.py` says what they are. Ours draw noise,
reward and reset; MuJoCo's tables are bare physics. "x same" and "x lean" are ratios to the fastest way of
stepping MuJoCo's table of that law in the same scene, "x pusht" to gym-pusht.
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
TURN = 0.15
"""How long a turn lasts, CPU seconds."""
LENGTHS = (1, 10, 25, 50)
"""Simulation steps in an action, from which its cost without any is found."""
IDS = {FREE: "LockedWheel", WALL: "PushDoor", GRIPPER: "LockedWheel"}
TARGETS = {FREE: 10.0, WALL: 1.2, GRIPPER: 1.2}
"""How many times as fast as MuJoCo ours should be."""
TIMES = 100.0
"""The same of gym-pusht, with nothing near."""
KIB = 64.0
"""What an environment may take, KiB."""
AHEAD = 0.05 + 0.6 + 0.004
"""From the middle of a wall to that of a table that stands before it with 4 mm between them, m."""


def options(scene: str, substeps: int = SUBSTEPS) -> dict[str, Any]:
    """Return what an environment of a scene is made with; its episodes end only where the object is lost."""
    action = "velocity" if scene == GRIPPER else "wrench"
    return {"action": action, "hidden": "locked", "step": STEP, "substeps": substeps, "horizon": 0}


def before_wall() -> dict[str, Any]:
    """Return reset options that put the table of seed 0 before a wall, beside the doorway, facing it."""
    seen = Observation(gymnasium.make("trundle/PushDoor-v0", **options(WALL)).reset(seed=0)[0])
    (x, y), (cos, sin) = seen.door_position, seen.door_direction
    beside = seen.door_width / 2 + 0.45
    return {"start": [x - AHEAD * cos - beside * sin, y - AHEAD * sin + beside * cos, np.arctan2(sin, cos)]}


def actions(scene: str, envs: int) -> list[Any]:
    """Return actions, to be repeated: a press against the wall, or random wrenches or velocities."""
    if scene == WALL:
        return [np.tile(np.float32([PRESS, 0.0, 0.0]), (envs, 1))]
    drawn = np.random.default_rng(0).uniform(-1.0, 1.0, (32, envs, 3)).astype(np.float32)
    return list(0.3 * drawn if scene == FREE else np.concatenate([drawn, -drawn]))


def single(scene: str, substeps: int = SUBSTEPS) -> Contestant:
    """Return one of our environments, in place."""
    env: Any = gymnasium.make(f"trundle/{IDS[scene]}-v0", **options(scene, substeps)).unwrapped
    env.reset(seed=0, options=before_wall() if scene == WALL else None)
    told, touched = [action[0] for action in actions(scene, 1)], [False]

    def act(calls: int) -> None:
        for k in range(calls):
            _, _, terminated, _, info = env.step(told[k % len(told)])
            if terminated:
                env.reset()
        touched[0] = info["touched"]

    return Contestant("trundle single", scene, 1, act, lambda: f"touched {touched[0]}")


def vector(scene: str, envs: int, substeps: int = SUBSTEPS) -> Contestant:
    """Return many of ours; at a wall all begin with the same seed, hence before the same one."""
    known = options(scene, substeps)
    env: Any = gymnasium.make_vec(f"trundle/{IDS[scene]}-v0", num_envs=envs, copy=False, **known)
    at_wall = scene == WALL
    env.reset(seed=[0] * envs if at_wall else 0, options=before_wall() if at_wall else None)
    told, touched = actions(scene, envs), [0]

    def act(calls: int) -> None:
        for k in range(calls):
            infos = env.step(told[k % len(told)])[-1]
        touched[0] = infos["touched"].sum()

    return Contestant(f"trundle make_vec {envs}", scene, envs, act, lambda: f"touched {touched[0]} of {envs}")


def turn(one: Contestant, calls: int) -> float:
    """Return the CPU seconds that a step of an environment takes."""
    began = process_time()
    one.act(calls)
    return (process_time() - began) / (calls * one.envs)


def timed(contestants: Iterable[Contestant], rounds: int) -> dict[Contestant, float]:
    """Return the CPU seconds of a step, the least of as many turns as there are rounds."""
    calls: dict[Contestant, int] = {}
    for one in contestants:
        one.act(1 + 200 // one.envs if one.scene != WALL else 100)
        calls[one] = max(1, round(TURN / (turn(one, 1 + 100 // one.envs) * one.envs)))
    turns = [[turn(one, count) for one, count in calls.items()] for _ in range(rounds)]
    return dict(zip(calls, np.min(turns, axis=0).tolist(), strict=True))


def ours() -> Iterator[Contestant]:
    for scene in SCENES:
        yield single(scene)
        yield from (vector(scene, envs) for envs in ENVS)


def least(found: dict[Contestant, float], scene: str, name: str) -> float:
    """Return what a step takes at least in a scene, by contestants of names that begin so."""
    times = (took for one, took in found.items() if one.scene == scene and one.name.startswith(name))
    return min(times, default=np.nan)


def show(found: dict[Contestant, float]) -> None:
    """Print all, scene by scene, and how they compare."""
    print(f"{'':36}{'':>7}{'steps per':>11}{'ns per':>9}")
    print(f"{'':36}{'envs':>7}{'CPU-second':>11}{'step':>9}{'x same':>9}{'x lean':>9}{'x pusht':>9}")
    pusht = least(found, OWN, PUSHT)
    for scene in (*SCENES, OWN):
        print(scene)
        peers = (*(least(found, scene, f"MuJoCo {law}") for law in LAWS), pusht)
        for one, took in ((one, took) for one, took in found.items() if one.scene == scene):
            ratios = "".join(f"{peer / took:9.2f}".replace("nan", "  -") for peer in peers)
            touching = f"  {one.touching()}" if scene == WALL else ""
            print(f"  {one.name:34}{one.envs:7}{1 / took:11,.0f}{1e9 * took:9,.0f}{ratios}{touching}")


def judge(found: dict[Contestant, float]) -> None:
    """Print which targets are reached by the fastest of ours."""
    print("\nthe fastest of ours against the fastest of theirs")
    pairs = [(scene, scene, f"MuJoCo {law}", times) for scene, times in TARGETS.items() for law in LAWS]
    for scene, where, name, target in [*pairs, (FREE, OWN, PUSHT, TIMES)]:
        ratio = least(found, where, name) / least(found, scene, "trundle")
        print(f"  {scene + ', ' + name:42}{ratio:9.2f}  {verdict(ratio, target)}")


def verdict(ratio: float, target: float) -> str:
    if np.isnan(ratio):
        return "not measured"
    return f"{'reached' if ratio >= target else 'missed'}: {target:g}"


def beyond(rounds: int) -> None:
    """Print what a step costs beside physics: lines through the times of actions of different length."""
    heads = "".join(f"{head:>9}" for head in (*LENGTHS, "each", "at none"))
    print(f"\n{'ns by simulation steps in an action':42}{heads}")
    for scene in SCENES:
        kinds = [[single(scene, n) for n in LENGTHS], [vector(scene, MANY, n) for n in LENGTHS]]
        found = timed([one for kind in kinds for one in kind], rounds)
        for kind in kinds:
            times = np.array([1e9 * found[one] for one in kind])
            # Errors grow with the time.
            line = np.polyfit(LENGTHS, times, 1, w=1 / times)
            row = "".join(f"{value:9,.0f}" for value in (*times, *line))
            print(f"  {kind[0].name + ', ' + scene:40}{row}")


def resident() -> float:
    """Return the memory that this process has, KiB (Linux)."""
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1024


def growth(scene: str) -> float:
    """Return by how much an environment raises this process's memory, KiB, once what all share is there."""
    vector(scene, 1).act(100)
    before = resident()
    many = vector(scene, MANY)
    many.act(100 if scene == WALL else 1)
    if scene == WALL and many.touching() != f"touched {MANY} of {MANY}":
        raise RuntimeError(f"not all are at the wall: {many.touching()}")
    return (resident() - before) / MANY


def memory() -> None:
    """Print it, of processes of their own."""
    print(f"\nKiB per environment, of {MANY}")
    for scene, name in ((FREE, "at rest"), (WALL, "all at a wall")):
        command = [sys.executable, __file__, "--growth", scene]
        taken = float(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
        print(f"  {name:42}{taken:9.1f}  {'reached' if taken < KIB else 'missed'}: {KIB:g}")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--rounds", type=int, default=9, help="turns of each")
    parser.add_argument("--growth", choices=SCENES, help=argparse.SUPPRESS)
    args = parser.parse_args()
    os.environ.setdefault("RAYON_NUM_THREADS", "1")
    if args.growth:
        print(growth(args.growth))
        return
    print(f"trundle {trundle.__version__}, {' '.join(os.uname())}")
    found = timed([*ours(), *others()], args.rounds)
    show(found)
    judge(found)
    beyond(args.rounds)
    memory()


if __name__ == "__main__":
    main()
