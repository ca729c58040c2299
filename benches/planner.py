"""What replanning costs beside pytorch_mppi, and what the whole adaptive loop costs.

python benches/planner.py --calls 200

A plan is one iteration of MPPI: 1,000 sampled plans of 20 actions of 0.1 s, rolled out, judged and averaged.
Times are CPU time on one thread, medians of calls that take turns; a ratio is the peer's time over ours, so
that above 1 ours is the faster. pytorch_mppi (pip install pytorch-mppi; it brings PyTorch) plans for a point
that goes as it is told, and for our wheel, table, steps and cost, written in PyTorch: in single precision,
with the cost counted once an action; ours is in double precision and counts it at both steps of an action.
The peer has neither dry friction nor obstacles: those rows are held against its plain wheel.
"""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Callable, Iterator
from importlib.metadata import version
from time import process_time
from typing import Any, NamedTuple

import gymnasium
import numpy as np
import tomli_w
from numpy.typing import NDArray

import trundle
from trundle.envs import Observation

SAMPLES, HORIZON, HOLD, STEPS = 1000, 20, 0.1, 2
"""Plans in an iteration, actions in a plan, how long each lasts (s), and steps in an action."""
FULL = np.array([100.0, 100.0, 40.0])
"""Bounds on an action: N, N, N m."""
FOOTPRINT = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
MASS = 22.0
WHEEL: dict[str, Any] = {"kind": "viscous_wheel", "x": -0.5, "y": 0.3, "angle": 0.3, "mu_x": 180, "mu_y": 320}
DRY: dict[str, Any] = {"kind": "coulomb_friction", "x": 0.5, "y": -0.3, "force": 14.0}
GRASP, GOAL = (-0.6, 0.0), (0.6, -0.5, 0.7)
OURS, PEER = "trundle", "pytorch_mppi"
TRIVIAL, ALIKE = "a point", "the same wheel"
WARM = 5
"""Calls that are not counted: the first find the ways round obstacles, or compile."""
LOOPS = ("LockedWheel", "PushAround", "PushDoor")


class Contestant(NamedTuple):
    """Something that plans: `plan` makes one."""

    who: str
    what: str
    plan: Callable[[], object]


def table(*effects: dict[str, Any]) -> trundle.Model:
    """Return the office table with effects."""
    body = {"footprint": FOOTPRINT, "mass": MASS}
    return trundle.Model.from_toml(
        tomli_w.dumps({"format": "trundle-model/1", "body": body, "effect": list(effects)})
    )


def doorway() -> tuple[list[float], list[float], list[Any]]:
    """Return pose and goal on either side of a doorway, and its walls, as an environment draws them."""
    env = gymnasium.make("trundle/PushDoor-v0")
    seen, _ = env.reset(seed=0)
    source: Any = env.unwrapped
    fields = Observation(seen)
    return fields.pose.tolist(), fields.goal_pose.tolist(), source.seen_obstacles(seen)


def ours(what: str, model: trundle.Model, through: bool = False, **settings: Any) -> Contestant:
    """Return our planner on a model, in the open or before a doorway."""
    planner = trundle.Planner(-FULL, FULL, horizon=HORIZON, hold=HOLD, **settings)
    start, goal, walls = doorway() if through else ([0.0] * 3, GOAL, [])
    return Contestant(OURS, what, lambda: planner.plan(model, start, [0.0] * 3, goal, GRASP, walls))


def planners() -> Iterator[Contestant]:
    """Yield ours, all for one iteration over as many plans."""
    one: dict[str, Any] = {"samples": SAMPLES, "iterations": 1}
    yield ours("one viscous wheel", table(WHEEL), **one)
    yield ours("a wheel and dry friction", table(WHEEL, DRY), **one)
    yield ours("one viscous wheel, at a doorway", table(WHEEL), through=True, **one)


def peers(compiled: bool) -> Iterator[Contestant]:
    """Yield pytorch_mppi on a point that goes where it is told, and on the wheel."""
    import torch
    from pytorch_mppi import MPPI

    torch.set_num_threads(1)
    torch.manual_seed(0)

    def planner(what: str, motion: Any, running: Any, terminal: Any, full: Any, states: int) -> Contestant:
        full = torch.tensor(full, dtype=torch.float32)
        mppi = MPPI(
            motion,
            running,
            nx=states,
            noise_sigma=torch.diag((0.6 * full) ** 2),
            num_samples=SAMPLES,
            horizon=HORIZON,
            terminal_state_cost=terminal,
            lambda_=0.02,
            u_min=-full,
            u_max=full,
        )
        if compiled:
            mppi.compile()
        start = torch.zeros(states)
        return Contestant(PEER, what, lambda: mppi.command(start, shift_nominal_trajectory=False))

    def nearness(state: Any, action: Any) -> Any:
        return ((state - 1.0) ** 2).sum(dim=1)

    yield planner(TRIVIAL, lambda state, action: state + HOLD * action, nearness, None, [1.0, 1.0], 2)
    print(f"pytorch_mppi {version('pytorch-mppi')}, torch {torch.__version__}{', compiled' * compiled}")
    print(f"the wheel in PyTorch is off ours by {gap(torch):.1e} m after {HORIZON * HOLD:g} s of pushing")
    yield planner(ALIKE, wheel(torch), *costs(torch), FULL.tolist(), 6)


def wheel(torch: Any) -> Any:
    """Return the table with a wheel for a batch of states (pose, twist) and actions.

    In the table's axes the twist follows a linear equation, of which a step is known beforehand.
    """
    dt = HOLD / STEPS
    keep, push = (torch.tensor(part.T, dtype=torch.float32) for part in solved(dt))

    def turned(twist: Any, angle: Any) -> Any:
        cos, sin = torch.cos(angle), torch.sin(angle)
        x, y, spin = twist.unbind(dim=1)
        return torch.stack([cos * x - sin * y, sin * x + cos * y, spin], dim=1)

    def motion(state: Any, action: Any) -> Any:
        pose, twist = state[:, :3], state[:, 3:]
        pushed = action @ push
        for _ in range(STEPS):
            middle = pose[:, 2] + 0.5 * dt * twist[:, 2]
            after = turned(turned(twist, -middle) @ keep + pushed, middle)
            pose, twist = pose + 0.5 * dt * (twist + after), after
        return torch.cat([pose, twist], dim=1)

    return motion


def solved(dt: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the matrices by which our steps take a twist and an action at the grasp to the next twist."""
    x, y, angle, mu_x, mu_y = (float(WHEEL[key]) for key in ("x", "y", "angle", "mu_x", "mu_y"))
    along, at = np.exp(1j * angle), np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
    axes = np.array([[along.real, -along.imag], [along.imag, along.real]])
    lightness = np.diag([1.0, 1.0, 12 / (1.2**2 + 0.8**2)]) / MASS
    c = dt * lightness @ at.T @ axes @ np.diag([mu_x, mu_y]) @ axes.T @ at
    carried = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-GRASP[1], GRASP[0], 1.0]])
    step = np.linalg.inv(np.eye(3) + c + c @ c / 2)
    return step, step @ (np.eye(3) + c / 2) @ lightness @ carried * dt


def costs(torch: Any) -> tuple[Any, Any]:
    """Return our cost of an action and of being left in a state."""
    goal, full = torch.tensor(GOAL), torch.tensor(FULL, dtype=torch.float32)

    def error(state: Any) -> Any:
        off = state[..., :3] - goal
        turn = torch.remainder(off[..., 2] + math.pi, 2 * math.pi) - math.pi
        return torch.linalg.vector_norm(off[..., :2], dim=-1) + 0.3 * turn.abs()

    def running(state: Any, action: Any) -> Any:
        speed, spin = torch.linalg.vector_norm(state[:, 3:5], dim=1), state[:, 5].abs()
        excess = (speed / 1.2 - 1).clamp(min=0) ** 2 + (spin / 2.5 - 1).clamp(min=0) ** 2
        return HOLD * (error(state) + 0.005 * ((action / full) ** 2).sum(dim=1) + 10 * excess)

    def terminal(states: Any, actions: Any) -> Any:
        last = states[0, :, -1]
        carried = torch.linalg.vector_norm(last[:, 3:5], dim=1) + 0.3 * last[:, 5].abs()
        return 0.5 * (error(last) + 0.3 * carried)

    return running, terminal


def gap(torch: Any) -> float:
    """Return how far the wheel in PyTorch ends from ours under the same pushes, m."""
    actions = np.random.default_rng(0).uniform(-0.4, 0.4, (HORIZON, 3)) * FULL
    motion, state = wheel(torch), torch.zeros((1, 6))
    pose, twist = np.zeros(3), np.zeros(3)
    for action in actions:
        state = motion(state, torch.tensor(action[None], dtype=torch.float32))
        push = [*action[:2], action[2] + GRASP[0] * action[1] - GRASP[1] * action[0]]
        poses, twists = table(WHEEL).rollout(pose, twist, [0.0, HOLD], [push, push])
        pose, twist = poses[-1], twists[-1]
    return float(np.hypot(*(state[0, :2].numpy() - pose[:2])))


def timed(contestants: list[Contestant], calls: int) -> dict[Contestant, float]:
    """Return the CPU seconds of a plan, the median of calls that take turns."""
    times: dict[Contestant, list[float]] = {one: [] for one in contestants}
    for turn in range(WARM + calls):
        for one, taken in times.items():
            began = process_time()
            one.plan()
            if turn >= WARM:
                taken.append(process_time() - began)
    return {one: float(np.median(taken)) for one, taken in times.items()}


def installed(compiled: bool) -> list[Contestant]:
    """Return the peer's planners, or say why there are none."""
    try:
        return list(peers(compiled))
    except ImportError as error:
        print(f"{PEER} is not installed: {error}")
        return []


def show(found: dict[Contestant, float]) -> None:
    """Print what a plan takes, and how many times as long the peer's take."""
    theirs = [(one.what, took) for one, took in found.items() if one.who == PEER]
    heads = "".join(f"{f'x {what}':>20}" for what, _ in theirs)
    print(f"\n{f'{SAMPLES} plans of {HORIZON} actions':44}{'CPU ms':>9}{heads}")
    for one, took in found.items():
        ratios = "".join(f"{their / took:20.2f}" for _, their in theirs) if one.who == OURS else ""
        print(f"{f'{one.who}, {one.what}':44}{1e3 * took:9.3f}{ratios}")


def replanning(calls: int) -> None:
    """Print what a call of the agent's own planner takes."""
    print("\nas the agent plans: 256 plans, 6 iterations")
    scenes = [
        ours("one viscous wheel", table(WHEEL)),
        ours("one viscous wheel, at a doorway", table(WHEEL), through=True),
    ]
    for one, took in timed(scenes, calls).items():
        print(f"{f'{one.who}, {one.what}':44}{1e3 * took:9.3f}{1 / took:9.0f} plans per second")


def loop(task: str, episodes: int) -> tuple[float, float, int]:
    """Return CPU seconds of the agent, seconds of pushing, and goals reached."""
    env: Any = gymnasium.make(f"trundle/{task}-v0", hidden="locked")
    agent = trundle.AdaptiveAgent(env)
    computing, steps, reached = 0.0, 0, 0
    for seed in range(episodes):
        observation, info = env.reset(seed=seed)
        first, over = True, False
        while not over:
            began = process_time()
            action, _ = agent.predict(observation, episode_start=first)
            computing += process_time() - began
            observation, _, terminated, truncated, info = env.step(action)
            first, over, steps = False, terminated or truncated, steps + 1
        reached += info["is_success"]
    return computing, steps * env.unwrapped.control, reached


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--calls", type=int, default=100, help="of each planner")
    parser.add_argument("--episodes", type=int, default=5, help="of each task of the loop")
    parser.add_argument("--compile", action="store_true", help="let torch.compile have the peer's models")
    args = parser.parse_args()
    os.environ["RAYON_NUM_THREADS"] = "1"
    print(f"trundle {trundle.__version__}, {' '.join(os.uname())}")
    show(timed([*planners(), *installed(args.compile)], args.calls))
    replanning(args.calls)
    print(f"\nthe whole loop, fits included: seeds 0 to {args.episodes - 1}, actions of 50 ms")
    for task in LOOPS:
        computing, seconds, reached = loop(task, args.episodes)
        print(f"{task:44}{computing / seconds:9.3f} CPU s per s of pushing, {reached} goals reached")


if __name__ == "__main__":
    main()
