"""Episodes with obstacles, resets and ordinary actions, in trundle and MuJoCo; see `environment.py`.

Actions are recorded once and replayed: a random walk of the wrench, or the same with a force towards the
goal. trundle plays them from the same seeds, so that every cycle has the same episodes, with resets, rewards
and noise. MuJoCo's tables start each second from the recorded state of the same episode, with the same wheel,
obstacles and wrench, and move without rewards, noise and observations.
"""

from __future__ import annotations

from collections.abc import Iterator
from time import process_time
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from numpy.typing import NDArray
from peers import MANY, RIM, WRENCH, Contestant

from trundle.envs import Observation

TASKS = ("PushAround", "PushDoor")
ACTIONS = WALK, TOWARDS = "random walk", "towards the goal"
FEW = 64
STEPS = 320
"""Actions of a cycle, of 50 ms or 25 simulation steps each."""
SUBSTEPS, STEP_S = 25, 0.002
SEGMENT = 20
"""Actions after which MuJoCo's tables start from a recorded state."""
OPTIONS: dict[str, Any] = {"hidden": "locked"}
TARGET_RATIO = 10.0
"""Target ratio to the speed of MuJoCo."""
TARGET_SINGLE_US = 10.0
"""Target for a step through `gymnasium.make`, µs."""

Array = NDArray[np.float64]


class Episode(NamedTuple):
    """One recorded environment: what MuJoCo needs to repeat its episodes."""

    actions: NDArray[np.float32]
    """Shape (STEPS, 3)."""
    models: list[str]
    """MuJoCo's model of the episode at each action; empty where a new episode begins."""
    states: Array
    """Pose and twist before each action, shape (STEPS, 6)."""
    wrenches: Array
    """World axes about the origin of the table, shape (STEPS, 3)."""


def record(task: str, kind: str, seed: int) -> Episode:
    """Play the actions of one environment as its batch does, without noise."""
    env: Any = gymnasium.make(f"trundle/{task}-v1", noise=0.0, **OPTIONS)
    rng, drift = np.random.default_rng(seed), np.zeros(3)
    observation, _ = env.reset(seed=seed)
    model, over = mjcf(env.unwrapped, observation), False
    actions, models, states, wrenches = [], [], [], []
    for _ in range(STEPS):
        drift = 0.95 * drift + 0.3 * np.sqrt(1.0 - 0.95**2) * rng.normal(size=3)
        seen = Observation(observation)
        cos, sin = seen.direction
        action = drift.copy()
        if kind == TOWARDS:
            away = seen.goal_position - seen.position
            action[:2] += 0.3 * np.array([cos * away[0] + sin * away[1], cos * away[1] - sin * away[0]])
        action = np.clip(action, -1.0, 1.0).astype(np.float32)
        (fx, fy, torque), (x, y) = action * WRENCH, seen.grasp
        actions.append(action)
        models.append("" if over else model)
        states.append([*seen.position, np.arctan2(sin, cos), *seen.velocity, float(seen.spin)])
        wrenches.append([cos * fx - sin * fy, sin * fx + cos * fy, torque + x * fy - y * fx])
        if over:
            observation, _ = env.reset()
            model, over = mjcf(env.unwrapped, observation), False
        else:
            observation, _, terminated, truncated, _ = env.step(action)
            over = terminated or truncated
    return Episode(np.array(actions), models, np.array(states), np.array(wrenches))


def mjcf(env: Any, observation: Array) -> str:
    """Return MuJoCo's model of the table, its wheel and the obstacles of an episode."""
    hidden = env.hidden_model()
    wheels = [effect for effect in hidden["effect"] if effect["kind"] == "viscous_wheel"]
    low, high = np.min(hidden["body"]["footprint"], axis=0), np.max(hidden["body"]["footprint"], axis=0)
    half, middle = (high - low) / 2, (high + low) / 2
    boxes = ""
    for polygon in env.seen_obstacles(observation):
        corners = np.array(polygon)
        along, across = corners[1] - corners[0], corners[3] - corners[0]
        center, angle = corners.mean(axis=0), np.arctan2(along[1], along[0])
        sizes = np.hypot(*along) / 2, np.hypot(*across) / 2
        boxes += (
            f'<geom type="box" size="{sizes[0]} {sizes[1]} 0.05" pos="{center[0]} {center[1]} 0" '
            f'euler="0 0 {angle}" {RIM}/>'
        )
    sites = "".join(
        f'<site name="wheel{k}" pos="{one["x"]} {one["y"]} 0" euler="0 0 {one["angle"]}"/>'
        for k, one in enumerate(wheels)
    )
    drags = "".join(
        f'<general site="wheel{k}" gear="{gear}" gainprm="0" biastype="affine" biasprm="0 0 {-one[name]}"/>'
        for k, one in enumerate(wheels)
        for gear, name in (("1 0 0 0 0 0", "mu_x"), ("0 1 0 0 0 0", "mu_y"))
    )
    return f"""
    <mujoco><compiler angle="radian"/><size memory="200K"/>
      <option timestep="{STEP_S}" gravity="0 0 0" integrator="implicitfast"/>
      <worldbody>{boxes}<body name="table">
        <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><joint type="hinge" axis="0 0 1"/>
        <geom type="box" size="{half[0]} {half[1]} 0.05" pos="{middle[0]} {middle[1]} 0"
          mass="{hidden["body"]["mass"]}" {RIM}/>{sites}
      </body></worldbody><actuator>{drags}</actuator></mujoco>"""


def batch(task: str, scene: str, episodes: list[Episode], envs: int) -> Contestant:
    """Return a batch of trundle that repeats the recorded episodes."""
    env: Any = gymnasium.make_vec(f"trundle/{task}-v1", num_envs=envs, copy=False, **OPTIONS)
    seeds = [index % len(episodes) for index in range(envs)]
    actions = np.stack([episodes[seed].actions for seed in seeds], axis=1)
    touched = [0]

    def act(calls: int) -> None:
        touched[0] = 0
        for _ in range(calls):
            env.reset(seed=seeds)
            for action in actions:
                infos = env.step(action)[-1]
                touched[0] += infos["touched"].sum() if "touched" in infos else 0

    share = lambda: f"touching an obstacle {touched[0] / (STEPS * envs):.0%}"  # noqa: E731
    return Contestant(f"trundle make_vec {envs}", scene, envs, act, share)


def single(task: str, scene: str, episodes: list[Episode]) -> Contestant:
    """Return one environment of `gymnasium.make`, with its wrappers, that repeats recorded episodes."""
    env: Any = gymnasium.make(f"trundle/{task}-v1", **OPTIONS)

    def act(calls: int) -> None:
        for seed in range(calls * SINGLES):
            env.reset(seed=seed)
            over = False
            for action in episodes[seed].actions:
                if over:
                    env.reset()
                    over = False
                else:
                    _, _, terminated, truncated, _ = env.step(action)
                    over = terminated or truncated

    return Contestant("trundle gymnasium.make", scene, SINGLES, act)


SINGLES = 16
"""Recorded environments that a single environment repeats one after the other."""


def mujoco_tables(scene: str, episodes: list[Episode]) -> Iterator[Contestant]:
    """Yield MuJoCo's tables in the recorded episodes, stepped by `mj_step` and by `rollout`."""
    import mujoco
    from mujoco import rollout

    compiled: dict[str, Any] = {"": None}
    for text in {text for one in episodes for text in one.models if text}:
        compiled[text] = mujoco.MjModel.from_xml_string(text)
    last = next(model for model in compiled.values() if model is not None)
    models = [[compiled[text] for text in one.models] for one in episodes]
    for row in models:
        # A step in which trundle starts an episode moves a table too.
        for k, model in enumerate(row):
            row[k] = last = model or last
    datas = {id(model): mujoco.MjData(model) for row in models for model in row}
    step, touched = mujoco.mj_step, [0]

    def act(calls: int) -> None:
        touched[0] = 0
        for _ in range(calls):
            for row, one in zip(models, episodes, strict=True):
                before = None
                for k, (model, wrench) in enumerate(zip(row, one.wrenches, strict=True)):
                    if k % SEGMENT == 0 or model is not before:
                        data, before = datas[id(model)], model
                        data.qpos[:], data.qvel[:] = one.states[k, :3], one.states[k, 3:]
                    data.qfrc_applied[:] = wrench
                    step(model, data, SUBSTEPS)
                    touched[0] += data.ncon > 0

    share = lambda: f"in contact {touched[0] / (STEPS * len(episodes)):.0%}"  # noqa: E731
    yield Contestant("MuJoCo mj_step", scene, len(episodes), act, share)

    roll, worker = rollout.Rollout(nthread=0), mujoco.MjData(last)
    size = mujoco.mj_stateSize(last, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    state, states = np.zeros((len(episodes), size)), np.zeros((len(episodes), SUBSTEPS, size))
    starts = np.stack([one.states for one in episodes], axis=1)
    controls = np.stack([one.wrenches for one in episodes], axis=1)[:, :, None].repeat(SUBSTEPS, axis=2)
    spec = mujoco.mjtState.mjSTATE_QFRC_APPLIED.value
    rows = list(zip(*models, strict=True))

    def act_rollout(calls: int) -> None:
        for _ in range(calls):
            for k, row in enumerate(rows):
                if k % SEGMENT == 0:
                    state[:, 1:7] = starts[k]
                roll.rollout(row, worker, state, controls[k], control_spec=spec, nstep=SUBSTEPS, state=states)
                state[:] = states[:, -1]

    yield Contestant("MuJoCo rollout", scene, len(episodes), act_rollout)


def print_mix(rounds: int) -> None:
    """Print the time of a step, the fastest of `rounds` cycles, and ratios to MuJoCo."""
    print(f"\n{'episodes with obstacles, steps of 50 ms':46}{'µs per step':>12}{'x MuJoCo':>10}")
    for task in TASKS:
        for kind in ACTIONS:
            scene = f"{task}-v1, {kind}"
            episodes = [record(task, kind, seed) for seed in range(FEW)]
            contestants = [batch(task, scene, episodes, envs) for envs in (FEW, MANY)]
            contestants.append(single(task, scene, episodes))
            try:
                contestants += mujoco_tables(scene, episodes)
            except ImportError as error:
                print(f"not available: MuJoCo: {error}")
            print_scene(scene, contestants, rounds)


def print_scene(scene: str, contestants: list[Contestant], rounds: int) -> None:
    """Print the contestants of a scene, each the fastest of `rounds` cycles, in turns."""
    print(scene)
    turns = np.array([[cycle_time(one) for one in contestants] for _ in range(rounds)])
    fastest = dict(zip(contestants, turns.min(axis=0).tolist(), strict=True))
    peer = min((time for one, time in fastest.items() if one.name.startswith("MuJoCo")), default=np.nan)
    for one, time in fastest.items():
        verdict = ""
        if one.name.startswith("trundle make_vec"):
            verdict = "reached" if peer / time >= TARGET_RATIO else f"missed: {TARGET_RATIO:g}"
        elif one.name.startswith("trundle"):
            verdict = "reached" if time < TARGET_SINGLE_US else f"missed: {TARGET_SINGLE_US:g} µs"
        print(f"  {one.name:44}{time:12.2f}{peer / time:10.2f}  {verdict}  {one.touching()}")


def cycle_time(one: Contestant) -> float:
    """Return the CPU time of a step in one cycle, µs."""
    start = process_time()
    one.act(1)
    return 1e6 * (process_time() - start) / (STEPS * one.envs)
