"""CPU time of a plan in comparison with pytorch_mppi, and of the complete adaptive loop.

python benches/planner.py --calls 200

A plan is one iteration of MPPI: 1,000 sampled plans of 20 actions of 0.1 s are rolled out, rated and
averaged. Times are CPU times on one thread, medians of calls that take turns. A ratio is the peer's time
divided by trundle's, so that trundle is faster above 1.

pytorch_mppi (pip install pytorch-mppi; it installs PyTorch) plans for a point with velocity control, and for
trundle's wheel, table, steps and cost, written in PyTorch. It uses single precision and evaluates the cost
once per action; trundle uses double precision and evaluates it at both steps of an action. The peer has
neither dry friction nor obstacles, so these rows are compared with its plain wheel.
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
"""Plans per iteration, actions per plan, duration of an action (s), and steps per action."""
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
"""Calls that do not count: the first ones find paths around obstacles, or compile."""
LOOPS = ("LockedWheel", "PushAround", "PushDoor")


class Contestant(NamedTuple):
    """A timed planner: `plan` makes one plan."""

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
    """Return a start and a goal on opposite sides of a doorway, and its walls, as drawn by an environment."""
    env = gymnasium.make("trundle/PushDoor-v0")
    seen, _ = env.reset(seed=0)
    source: Any = env.unwrapped
    fields = Observation(seen)
    return fields.pose.tolist(), fields.goal_pose.tolist(), source.seen_obstacles(seen)


def trundle_planner(what: str, model: trundle.Model, through: bool = False, **settings: Any) -> Contestant:
    """Return trundle's planner with a model, in the open or at a doorway."""
    planner = trundle.Planner(-FULL, FULL, horizon=HORIZON, hold=HOLD, **settings)
    start, goal, walls = doorway() if through else ([0.0] * 3, GOAL, [])
    return Contestant(OURS, what, lambda: planner.plan(model, start, [0.0] * 3, goal, GRASP, walls))


def trundle_planners() -> Iterator[Contestant]:
    """Yield trundle's planners, each for one iteration over the same number of plans."""
    one: dict[str, Any] = {"samples": SAMPLES, "iterations": 1}
    yield trundle_planner("one viscous wheel", table(WHEEL), **one)
    yield trundle_planner("a wheel and dry friction", table(WHEEL, DRY), **one)
    yield trundle_planner("one viscous wheel, at a doorway", table(WHEEL), through=True, **one)


def peer_planners(compiled: bool) -> Iterator[Contestant]:
    """Yield pytorch_mppi on a point with velocity control, and on the wheel."""
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
    difference, duration = torch_difference(torch), HORIZON * HOLD
    print(f"the wheel in PyTorch differs by {difference:.1e} m after {duration:g} s of pushing")
    yield planner(ALIKE, torch_wheel(torch), *torch_costs(torch), FULL.tolist(), 6)


def torch_wheel(torch: Any) -> Any:
    """Return the table with a wheel for a batch of states (pose, twist) and actions.

    In the axes of the table the twist follows a linear equation, whose step is precomputed.
    """
    dt = HOLD / STEPS
    keep, push = (torch.tensor(part.T, dtype=torch.float32) for part in step_matrices(dt))

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


def step_matrices(dt: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the matrices of trundle's step, from a twist and an action at the grasp to the next twist."""
    x, y, angle, mu_x, mu_y = (float(WHEEL[key]) for key in ("x", "y", "angle", "mu_x", "mu_y"))
    along, at = np.exp(1j * angle), np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
    axes = np.array([[along.real, -along.imag], [along.imag, along.real]])
    inverse_mass = np.diag([1.0, 1.0, 12 / (1.2**2 + 0.8**2)]) / MASS
    c = dt * inverse_mass @ at.T @ axes @ np.diag([mu_x, mu_y]) @ axes.T @ at
    carried = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-GRASP[1], GRASP[0], 1.0]])
    step = np.linalg.inv(np.eye(3) + c + c @ c / 2)
    return step, step @ (np.eye(3) + c / 2) @ inverse_mass @ carried * dt


def torch_costs(torch: Any) -> tuple[Any, Any]:
    """Return trundle's running cost and terminal cost."""
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


def torch_difference(torch: Any) -> float:
    """Return the final distance of the wheel in PyTorch from trundle's under the same pushes, m."""
    actions = np.random.default_rng(0).uniform(-0.4, 0.4, (HORIZON, 3)) * FULL
    motion, state = torch_wheel(torch), torch.zeros((1, 6))
    pose, twist = np.zeros(3), np.zeros(3)
    for action in actions:
        state = motion(state, torch.tensor(action[None], dtype=torch.float32))
        push = [*action[:2], action[2] + GRASP[0] * action[1] - GRASP[1] * action[0]]
        poses, twists = table(WHEEL).rollout(pose, twist, [0.0, HOLD], [push, push])
        pose, twist = poses[-1], twists[-1]
    return float(np.hypot(*(state[0, :2].numpy() - pose[:2])))


def plan_times(contestants: list[Contestant], calls: int) -> dict[Contestant, float]:
    """Return the CPU time of a plan, s: the median of calls that take turns."""
    times: dict[Contestant, list[float]] = {one: [] for one in contestants}
    for turn in range(WARM + calls):
        for one, taken in times.items():
            start_time = process_time()
            one.plan()
            if turn >= WARM:
                taken.append(process_time() - start_time)
    return {one: float(np.median(taken)) for one, taken in times.items()}


def installed_peers(compiled: bool) -> list[Contestant]:
    """Return the peer's planners, or print why there are none."""
    try:
        return list(peer_planners(compiled))
    except ImportError as error:
        print(f"{PEER} is not installed: {error}")
        return []


def print_times(durations: dict[Contestant, float]) -> None:
    """Print the time of a plan and the ratio to the peer."""
    theirs = [(one.what, duration) for one, duration in durations.items() if one.who == PEER]
    heads = "".join(f"{f'x {what}':>20}" for what, _ in theirs)
    print(f"\n{f'{SAMPLES} plans of {HORIZON} actions':44}{'CPU ms':>9}{heads}")
    for one, duration in durations.items():
        ratios = "".join(f"{their / duration:20.2f}" for _, their in theirs) if one.who == OURS else ""
        print(f"{f'{one.who}, {one.what}':44}{1e3 * duration:9.3f}{ratios}")


def print_agent_times(calls: int) -> None:
    """Print the time of a plan with the agent's settings."""
    print("\nsettings of the agent: 256 plans, 6 iterations")
    scenes = [
        trundle_planner("one viscous wheel", table(WHEEL)),
        trundle_planner("one viscous wheel, at a doorway", table(WHEEL), through=True),
    ]
    for one, duration in plan_times(scenes, calls).items():
        print(f"{f'{one.who}, {one.what}':44}{1e3 * duration:9.3f}{1 / duration:9.0f} plans per second")


def run_loop(task: str, episodes: int) -> tuple[float, float, int]:
    """Return the CPU time of the agent (s), the time of pushing (s), and the number of goals reached."""
    env: Any = gymnasium.make(f"trundle/{task}-v0", hidden="locked")
    agent = trundle.AdaptiveAgent(env)
    computing, steps, reached = 0.0, 0, 0
    for seed in range(episodes):
        observation, info = env.reset(seed=seed)
        first, over = True, False
        while not over:
            start_time = process_time()
            action, _ = agent.predict(observation, episode_start=first)
            computing += process_time() - start_time
            observation, _, terminated, truncated, info = env.step(action)
            first, over, steps = False, terminated or truncated, steps + 1
        reached += info["is_success"]
    return computing, steps * env.unwrapped.control, reached


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--calls", type=int, default=100, help="calls of each planner (default 100)")
    parser.add_argument("--episodes", type=int, default=5, help="episodes of each task (default 5)")
    parser.add_argument("--compile", action="store_true", help="compile the peer's models with torch.compile")
    args = parser.parse_args()
    os.environ["RAYON_NUM_THREADS"] = "1"
    print(f"trundle {trundle.__version__}, {' '.join(os.uname())}")
    print_times(plan_times([*trundle_planners(), *installed_peers(args.compile)], args.calls))
    print_agent_times(args.calls)
    print(f"\ncomplete loop with estimation: seeds 0 to {args.episodes - 1}, actions of 50 ms")
    for task in LOOPS:
        computing, seconds, reached = run_loop(task, args.episodes)
        print(f"{task:44}{computing / seconds:9.3f} CPU s per s of pushing, {reached} goals reached")


if __name__ == "__main__":
    main()
