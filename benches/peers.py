"""Peers of `environment.py`: MuJoCo with the same table, and other pushing environments.

They are not dependencies of trundle: pip install gym-pusht envpool "gymnasium[mujoco]".

MuJoCo simulates two tables. "the same law" is a box on an anisotropic wheel: two actuators at a site whose
force is minus a coefficient times the velocity of the site. The wall is a box, and the gripper is a weld to a
mocap body. "cheapest law" is the fastest model, even with another law: joints with damping, explicit
integration, no collision detection away from obstacles, a ball in each corner against a plane as the wall,
and three springs between two sites as the gripper.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from numpy.typing import NDArray

STEP, SUBSTEPS = 0.002, 10
"""Simulation step, s, and number of simulation steps per action."""
SCENES = FREE, WALL, GRIPPER = "free motion", "at a wall", "under the gripper"
OWN = "other scenes"
PUSHT = "gym-pusht"
LAWS = SAME, LEAN = "the same law", "cheapest law"
MANY = 1024
WRENCH, VELOCITY = (100.0, 100.0, 40.0), 0.3
"""Full action: N and N m; m/s."""
PRESS = 0.6
"""Force against the wall, as a share of the full force."""


class Contestant(NamedTuple):
    """A timed simulation: `act` makes a number of calls, each of which steps all `envs` environments."""

    name: str
    scene: str
    envs: int
    act: Callable[[int], None]
    touching: Callable[[], str] = str
    """Returns a description of its contacts, if it reports any."""


XML = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="{step}" gravity="0 0 0" {option}</option>
  <worldbody>
    {around}
    <body name="table">
      <joint type="slide" axis="1 0 0" damping="{damping}"/>
      <joint type="slide" axis="0 1 0" damping="{damping}"/>
      <joint type="hinge" axis="0 0 1" damping="{damping}"/>
      {shape}
      <site name="wheel" pos="-0.5 -0.3 0" euler="0 0 0.2"/>
      <site name="grasp" pos="-0.6 0 0"/>
    </body>
  </worldbody>
  {held}
  <actuator>{actuators}</actuator>
</mujoco>
"""
PLAIN = 'integrator="implicitfast">'
CHEAP = 'integrator="Euler" cone="elliptic">'
CLEAR = 'integrator="Euler"><flag contact="disable"/>'
RIM = 'friction="0.3 0 0" condim="3"'
BOX = f'<geom type="box" size="0.6 0.4 0.05" mass="22" {RIM}/>'
BALLS = '<inertial pos="0 0 0" mass="22" diaginertia="2 2 3.81"/>' + "".join(
    f'<geom type="sphere" size="0.01" pos="{x} {y} 0" {RIM}/>' for x in (-0.59, 0.59) for y in (-0.39, 0.39)
)
AROUND = {
    (WALL, SAME): f'<geom type="box" size="0.05 3 0.05" pos="0.651 0 0" {RIM}/>',
    (WALL, LEAN): f'<geom type="plane" size="3 3 1" pos="0.601 0 0" zaxis="-1 0 0" {RIM}/>',
}
HAND = '<body name="hand" mocap="true" pos="-0.6 0 0"><site name="hand"/></body>'


def affine(site: str, gear: str, stiffness: float, damping: float) -> str:
    """Return an actuator that damps the motion of a site, or acts against its displacement from the hand."""
    frame = 'refsite="hand"' if stiffness else ""
    bias = f'gainprm="0" biastype="affine" biasprm="0 {-stiffness} {-damping}"'
    return f'<general site="{site}" {frame} gear="{gear}" {bias}/>'


WHEEL = affine("wheel", "1 0 0 0 0 0", 0, 100) + affine("wheel", "0 1 0 0 0 0", 0, 200)
SPRINGS = (
    affine("grasp", "1 0 0 0 0 0", 1e4, 400)
    + affine("grasp", "0 1 0 0 0 0", 1e4, 400)
    + affine("grasp", "0 0 0 0 0 1", 300, 30)
)
# The stiffness of the springs: 5 mm at 50 N, 0.034 rad at 10 N m.
FIT = 'solref="-300 -12" solimp="0.01 0.01 0.001" torquescale="0.583"'
WELD = f'<equality><weld body1="hand" body2="table" {FIT}/></equality>'


def mjcf(scene: str, law: str) -> str:
    """Return MuJoCo's model of a scene."""
    lean, held = law == LEAN, scene == GRIPPER
    return XML.format(
        step=STEP,
        option=(CHEAP if scene == WALL else CLEAR) if lean else PLAIN,
        damping=40 if lean else 0,
        around=HAND if held else AROUND.get((scene, law), ""),
        shape=BALLS if lean and scene == WALL else BOX,
        held=WELD if held and not lean else "",
        actuators=("" if lean else WHEEL) + (SPRINGS if lean and held else ""),
    )


def inputs(scene: str) -> list[NDArray[np.float64]]:
    """Return the inputs of MuJoCo by action: wrenches in world axes, or positions of the hand."""
    drawn = np.random.default_rng(0).uniform(-1.0, 1.0, (32, 3))
    if scene == FREE:
        return list(0.3 * drawn * WRENCH)
    if scene == WALL:
        return [np.array([PRESS * WRENCH[0], 0.0, 0.0])]
    there_and_back = np.concatenate([drawn, -drawn]) * [1.0, 1.0, 0.0]
    places = np.cumsum(there_and_back, axis=0) * VELOCITY * STEP * SUBSTEPS + [-0.6, 0.0, 0.0]
    return list(places[:, None])


def step_loop(mujoco: Any, model: Any, cycle: list[Any], field: str) -> tuple[Any, Any]:
    """Return a loop over `mj_step`, and its data."""
    data = mujoco.MjData(model)
    step, target = mujoco.mj_step, getattr(data, field)

    def act(calls: int) -> None:
        for k in range(calls):
            target[:] = cycle[k % len(cycle)]
            step(model, data, SUBSTEPS)

    return act, data


def rollout_loop(mujoco: Any, model: Any, cycle: list[Any], field: str) -> Any:
    """Return a loop over `mujoco.rollout` with one call per action, as an environment requires."""
    from mujoco import rollout

    roll, data = rollout.Rollout(nthread=0), mujoco.MjData(model)
    size = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    state, states = np.zeros((MANY, size)), np.zeros((MANY, SUBSTEPS, size))
    spec = getattr(mujoco.mjtState, f"mjSTATE_{field.upper()}").value
    controls = [np.tile(one.reshape(1, 1, -1), (MANY, SUBSTEPS, 1)) for one in cycle]

    def act(calls: int) -> None:
        for k in range(calls):
            control = controls[k % len(controls)]
            roll.rollout(model, data, state, control, control_spec=spec, nstep=SUBSTEPS, state=states)
            state[:] = states[:, -1]

    return act


def batch_loop(model: Any, cycle: list[Any], field: str) -> Any:
    """Return a loop over `mujoco.batch` (MuJoCo 4)."""
    from mujoco.batch import Batch

    batch = Batch(model, MANY, nthread=1)
    target = batch.bind(field)

    def act(calls: int) -> None:
        for k in range(calls):
            target[...] = cycle[k % len(cycle)]
            batch.step(nstep=SUBSTEPS)

    return act


def mujoco_tables() -> Iterator[Contestant]:
    """Yield MuJoCo's tables, each with every available way of stepping."""
    import mujoco

    for scene in SCENES:
        field = "mocap_pos" if scene == GRIPPER else "qfrc_applied"
        for law in LAWS:
            model, cycle = mujoco.MjModel.from_xml_string(mjcf(scene, law)), inputs(scene)
            act, data = step_loop(mujoco, model, cycle, field)
            name = f"MuJoCo {law}:"
            yield Contestant(f"{name} mj_step", scene, 1, act, lambda data=data: f"{data.ncon} contacts")
            yield Contestant(f"{name} rollout", scene, MANY, rollout_loop(mujoco, model, cycle, field))
            try:
                yield Contestant(f"{name} batch", scene, MANY, batch_loop(model, cycle, field))
            except ImportError as error:
                print(f"not available: {name} batch: {error}")


def gymnasium_environment(name: str, spec: str, **options: Any) -> Contestant:
    """Return a Gymnasium environment under random actions."""
    env = gymnasium.make(spec, **options).unwrapped
    env.reset(seed=0)
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(64)]

    def act(calls: int) -> None:
        for k in range(calls):
            _, _, terminated, truncated, _ = env.step(actions[k % 64])
            if terminated or truncated:
                env.reset()

    return Contestant(name, OWN, 1, act)


def envpool_pusher() -> Contestant:
    """Return EnvPool's Pusher, which is stepped outside the interpreter."""
    import envpool

    envs = envpool.make_gymnasium("Pusher-v5", num_envs=64, num_threads=1)
    envs.reset()
    actions = np.random.default_rng(0).uniform(-2.0, 2.0, (64, 7))

    def act(calls: int) -> None:
        for _ in range(calls):
            envs.step(actions)

    return Contestant("EnvPool's Pusher-v5", OWN, 64, act)


def others() -> Iterator[Contestant]:
    """Yield the installed peers, and print the others."""
    makes: dict[str, Callable[[], Iterable[Contestant]]] = {
        "MuJoCo's tables": mujoco_tables,
        PUSHT: lambda: [gymnasium_environment(PUSHT, "gym_pusht:gym_pusht/PushT-v0", obs_type="state")],
        "Pusher-v5": lambda: [gymnasium_environment("Pusher-v5", "Pusher-v5")],
        "EnvPool": lambda: [envpool_pusher()],
    }
    for name, make in makes.items():
        try:
            yield from make()
        except (ImportError, gymnasium.error.Error) as error:
            print(f"not available: {name}: {error}")
