"""Adaptive agent on a plant of another engine: a table on rollers in MuJoCo, one of which is stiff.

    python examples/mujoco_plant.py [--episodes 5] [--seed 0]

MuJoCo simulates gravity, four balls that roll on the floor, and their bearings. The agent does not know which
bearing is stiff. `RollerTable` has all that the agent requires of an environment: the spaces of
`trundle/PushPose-v0`, `ACTION_SCALE` and `recording_metadata`. Requires `trundle[mujoco]`.
"""

from __future__ import annotations

import argparse
from typing import Any

import gymnasium
import mujoco
import numpy as np
from numpy.typing import NDArray

import trundle

Floats = NDArray[np.float64]

MASS, RADIUS = 22.0, 0.05
FEET = [(-0.5, -0.3), (0.5, -0.3), (0.5, 0.3), (-0.5, 0.3)]
FOOTPRINT = [(-0.6, -0.4), (0.6, -0.4), (0.6, 0.4), (-0.6, 0.4)]
GRASP = (-0.6, 0.0)
FREE, STIFF = 1.0, (60.0, 300.0)
"""Drag of a normal roller (not in the agent's model), and range of that of the stiff one, N s/m."""
STEP, CONTROL, RISE = 5e-4, 0.05, 0.02
"""Simulation step, interval between actions, and rise time of an action, s."""
POSE_NOISE, TWIST_NOISE, READING_NOISE = (5e-4, 5e-4, 1.75e-3), (5e-3, 5e-3, 1e-2), (0.4, 0.4, 0.05)
BOUNDS = np.array([3, 3, 1, 1, 4, 4, 7, 3, 3, 1, 1, 120, 120, 43, 1.5, 1.5])

ROLLERS = "".join(
    f"""
      <body pos="{x} {y} 0">
        <joint name="roller{k}" type="ball"/><geom type="sphere" size="{RADIUS}" mass="0.2"/>
      </body>"""
    for k, (x, y) in enumerate(FEET)
)
# With friction 3 the balls do not slip, so that the drag of the stiff one is that of its bearing.
TABLE = f"""
<mujoco>
  <option timestep="{STEP}" integrator="implicitfast" cone="elliptic" impratio="10"/>
  <default><geom friction="3" solref="0.004 1"/></default>
  <worldbody>
    <geom type="plane" size="5 5 1"/>
    <body name="table" pos="0 0 {RADIUS}">
      <freejoint/>
      <geom type="box" size="0.6 0.4 0.02" mass="{MASS - 0.2 * len(FEET)}" contype="0" conaffinity="0"/>
      <site name="gripper" pos="{GRASP[0]} {GRASP[1]} 0"/>{ROLLERS}
    </body>
  </worldbody>
  <actuator>
    <motor site="gripper" gear="1 0 0 0 0 0"/>
    <motor site="gripper" gear="0 1 0 0 0 0"/>
    <motor site="gripper" gear="0 0 0 0 0 1"/>
  </actuator>
</mujoco>"""


class RollerTable(gymnasium.Env[Floats, NDArray[np.float32]]):
    """Push the table to a pose 0.4 to 1 m away. The task is that of `trundle.envs.PushPose`."""

    ACTION_SCALE = np.array([100.0, 100.0, 40.0])

    def __init__(self) -> None:
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (3,), np.float32)
        self.observation_space = gymnasium.spaces.Box(-BOUNDS, BOUNDS, dtype=np.float64)
        self.model = mujoco.MjModel.from_xml_string(TABLE)
        self.data = mujoco.MjData(self.model)
        self.goal, self.steps, self.stuck, self.drag = np.zeros(3), 0, 0, 0.0

    def recording_metadata(self, name: str) -> dict[str, Any]:
        """Return the metadata of table and instruments, without the rollers."""
        noise = {"pose": POSE_NOISE, "force": READING_NOISE[0], "torque": READING_NOISE[2]}
        wrench = {"frame": "sensor", "sign": "on_object", "raw": False, "contact": "grasp"}
        body = {"footprint": FOOTPRINT, "support": FEET}
        known = {"object": body, "wrench": wrench, "noise": noise}
        return {"format": "trundle-recording/1", "name": name, **known}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Draw the stiff roller, its drag, the start and the goal."""
        super().reset(seed=seed)
        rng = self.np_random
        self.stuck, self.drag = int(rng.integers(len(FEET))), float(np.exp(rng.uniform(*np.log(STIFF))))
        for k in range(len(FEET)):
            # A ball at speed v rotates at v / r. The bearing torque is r times the force at the floor.
            first = self.model.joint(f"roller{k}").dofadr[0]
            self.model.dof_damping[first : first + 3] = (self.drag if k == self.stuck else FREE) * RADIUS**2
        x, y, angle = *rng.uniform(-0.5, 0.5, 2), rng.uniform(-np.pi, np.pi)
        far, way, turn = rng.uniform(0.4, 1.0), rng.uniform(-np.pi, np.pi), rng.uniform(-0.8, 0.8)
        self.goal = np.array([x + far * np.cos(way), y + far * np.sin(way), angle + turn])
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:7] = [x, y, RADIUS, np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)]
        mujoco.mj_step(self.model, self.data, round(0.1 / STEP))  # settles on the floor
        self.steps = 0
        return self.observed(), {}

    def step(self, action: NDArray[np.float32]) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
        """Push for 50 ms: the wrench at the grasp rises to the action and stays constant."""
        before, wanted = self.data.ctrl.copy(), self.ACTION_SCALE * action
        for k in range(round(CONTROL / STEP)):
            self.data.ctrl[:] = before + min(1.0, (k + 0.5) * STEP / RISE) * (wanted - before)
            mujoco.mj_step(self.model, self.data)
        self.steps += 1
        (x, y, angle), (vx, vy, spin) = self.motion()
        distance, speed = float(np.hypot(x - self.goal[0], y - self.goal[1])), np.hypot(vx, vy)
        off = float(np.angle(np.exp(1j * (angle - self.goal[2]))))
        success = bool(distance < 0.05 and abs(off) < 0.1 and speed < 0.1)
        lost = bool(max(abs(x), abs(y)) > 2.5 or speed > 2.0 or abs(spin) > 4.0)
        reward = -CONTROL * (distance + 0.3 * abs(off)) - 100.0 * lost
        info = {"is_success": success, "lost": lost, "distance": distance, "heading_error": off}
        return self.observed(), reward, success or lost, self.steps >= 300, info

    def motion(self) -> tuple[Floats, Floats]:
        """Return true pose and twist of the table, world axes."""
        x, y, _, w, _, _, z = self.data.qpos[:7]
        return np.array([x, y, 2 * np.arctan2(z, w)]), self.data.qvel[[0, 1, 5]]

    def observed(self) -> Floats:
        """Return the measured observation, in the order of `trundle.envs.Push`."""
        (pose, twist), rng = self.motion(), self.np_random
        x, y, angle = pose + rng.normal(0.0, POSE_NOISE)
        goal = (*self.goal[:2], np.cos(self.goal[2]), np.sin(self.goal[2]))
        seen, reading = twist + rng.normal(0.0, TWIST_NOISE), self.data.ctrl + rng.normal(0.0, READING_NOISE)
        row = np.array([x, y, np.cos(angle), np.sin(angle), *seen, *goal, *reading, *GRASP])
        clipped: Floats = np.clip(row, -BOUNDS, BOUNDS)
        return clipped


def play(env: RollerTable, agent: trundle.AdaptiveAgent, seed: int) -> tuple[dict[str, Any], trundle.Model]:
    """Run one episode; return its last info and the estimated model."""
    observation, info = env.reset(seed=seed)
    over = False
    while not over:
        action, (belief,) = agent.predict(observation, episode_start=env.steps == 0)
        observation, _, terminated, truncated, info = env.step(action)
        over = terminated or truncated
    return info, belief.model


def wheel(model: trundle.Model) -> str:
    """Return the position of a model's wheel (m) and its drags along and across (N s/m) as text."""
    found = {p["name"].removeprefix("viscous_wheel."): p["value"] for p in model.parameters}
    return "({x:5.2f}, {y:5.2f}) {mu_x:6.0f} {mu_y:4.0f}".format(**found) if "mu_x" in found else "no wheel"


def main() -> None:
    parser = argparse.ArgumentParser(description="Push a table in MuJoCo with the adaptive agent.")
    parser.add_argument("--episodes", type=int, default=5)
    parser.add_argument("--seed", type=int, default=0, help="seed of the first episode (default 0)")
    args = parser.parse_args()
    env = RollerTable()
    agent, reached = trundle.AdaptiveAgent(env), 0
    print(f"{'seed':>4}  {'goal':19}  {'stiff roller, m, N s/m':24}  estimated wheel")
    for seed in range(args.seed, args.seed + args.episodes):
        info, model = play(env, agent, seed)
        reached += info["is_success"]
        end = "reached after" if info["is_success"] else "lost after" if info["lost"] else "missed in"
        truth = "({:5.2f}, {:5.2f}) {:6.0f}".format(*FEET[env.stuck], env.drag)
        print(f"{seed:4}  {end:13} {CONTROL * env.steps:4.1f}s  {truth:24}  {wheel(model)}")
    print(f"{reached} of {args.episodes} goals reached")


if __name__ == "__main__":
    main()
