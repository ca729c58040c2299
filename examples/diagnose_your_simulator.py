"""Diagnose your own simulator: a table in MuJoCo, and a recording of it with one dragging foot.

    python examples/diagnose_your_simulator.py [--out diagnosis/table] [--episodes 5] [--seconds 6]

MuJoCo also makes the recording, with noise. The simulation under test is the same table on its casters
without the dragging foot. Requires `mujoco`. For your own simulator, get the recording with `trundle.read`,
and let `step` call the simulator.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import mujoco
import numpy as np
from numpy.typing import NDArray

import trundle

Floats = NDArray[np.float64]

FOOTPRINT = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
GYRATION = np.sqrt((1.2**2 + 0.8**2) / 12.0)
GRASP = np.array([-0.6, 0.1])
CONTACT = 0.5
NOISE = {"pose": [5e-4, 5e-4, 1.75e-3], "force": 0.4, "torque": 0.05}
TABLE = """
<mujoco>
  <option timestep="2e-3" gravity="0 0 0" integrator="implicitfast"/>
  <worldbody><body name="table">
    <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><joint type="hinge" axis="0 0 1"/>
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
  </body></worldbody>
</mujoco>
"""


class Table:
    """The simulation under test: a table on casters with isotropic viscous friction."""

    def __init__(self) -> None:
        self.model = mujoco.MjModel.from_xml_string(TABLE)
        self.data, self.scratch = mujoco.MjData(self.model), mujoco.MjData(self.model)
        self.values: dict[str, float] = {}

    def use(self, values: dict[str, float]) -> None:
        """Set the parameters, and the constants that MuJoCo derives from them."""
        model, self.values = self.model, dict(values)
        model.body_mass[1] = values["mass"]
        model.body_inertia[1] = values["mass"] * GYRATION**2
        model.dof_damping[:] = [values["rolling"], values["rolling"], values["turning"]]
        mujoco.mj_setConst(model, self.scratch)

    def step(self, state: Floats, wrench: Floats, dt: float, values: dict[str, float]) -> Floats:
        """Return the state after `dt` seconds, as `trundle.diagnose` requires."""
        model, data = self.model, self.data
        if values != self.values:
            self.use(values)
        steps = max(1, round(dt / 2e-3))
        model.opt.timestep = dt / steps
        data.qpos[:], data.qvel[:] = state[:3], state[3:]
        for _ in range(steps):
            data.qfrc_applied[:] = to_world(wrench, data.qpos[2])
            mujoco.mj_step(model, data)
        return np.concatenate([data.qpos, data.qvel])


def to_world(wrench: Floats, theta: float) -> Floats:
    """Transform a wrench from object axes to world axes."""
    cos, sin = np.cos(theta), np.sin(theta)
    return np.array([cos * wrench[0] - sin * wrench[1], sin * wrench[0] + cos * wrench[1], wrench[2]])


def dragging_foot(place: tuple[float, float], force: float) -> Callable[[Floats, Floats], Floats]:
    """Return the missing effect as a function of pose and twist: dry friction at one foot."""

    def wrench(pose: Floats, twist: Floats) -> Floats:
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        arm = np.array([cos * place[0] - sin * place[1], sin * place[0] + cos * place[1]])
        velocity = twist[:2] + twist[2] * np.array([-arm[1], arm[0]])
        drag = -force * velocity / np.sqrt(velocity @ velocity + 1e-8)
        return np.array([*drag, arm[0] * drag[1] - arm[1] * drag[0]])

    return wrench


def random_push(rng: np.random.Generator) -> Callable[[float], Floats]:
    """Return a push: the wrench at the grasp over time, gripper axes, N, N, N·m."""
    phase, rate = rng.uniform(-np.pi, np.pi, 3), rng.uniform(0.7, 1.3, 3)

    def wrench(t: float) -> Floats:
        since = t - CONTACT
        if since <= 0.0:
            return np.zeros(3)
        on = min(since / 0.2, 1.0)
        along = 28.0 * np.sin(2.2 * rate[0] * since + phase[0])
        return on * np.array(
            [along, 16.0 * np.sin(3.1 * rate[1] * since + phase[1]), 2.0 * np.sin(rate[2] * since)]
        )

    return wrench


def simulate_recording(
    hidden: Callable[[Floats, Floats], Floats] | None, episodes: int, seconds: float, seed: int = 0
) -> trundle.Recording:
    """Simulate a recording of the table with a small step; the last episode is held out."""
    table, tables = Table(), {}
    values = {"mass": 21.0, "rolling": 14.0, "turning": 3.0}
    dt = 5e-4
    for k in range(episodes):
        rng = np.random.default_rng([seed, k])
        pushed = random_push(rng)
        state = np.array([0.2 * k, -0.1 * k, 0.9 * k - 1.0, 0.0, 0.0, 0.0])
        rows = []
        for index in range(round(seconds / dt)):
            t = index * dt
            fx, fy, torque = pushed(t)
            if index % 8 == 0:
                rows.append([t, *state[:3], fx, fy, torque])
            wrench = np.array([fx, fy, torque + GRASP[0] * fy - GRASP[1] * fx])
            if hidden is not None and t > CONTACT:
                wrench += to_world(hidden(state[:3], state[3:]), -state[2])
            state = table.step(state, wrench, dt, values)
        tables[f"push_{k}"] = measured_columns(np.array(rows), rng)
    metadata = {
        "format": "trundle-recording/1",
        "name": "a table in MuJoCo",
        "object": {"footprint": FOOTPRINT},
        "wrench": {"frame": "sensor", "sign": "on_object", "raw": True, "precontact": [0.0, CONTACT - 0.05]},
        "noise": NOISE,
        "split": {"held_out": [f"push_{episodes - 1}"]},
    }
    return trundle.Recording(metadata, tables)


def measured_columns(rows: Floats, rng: np.random.Generator) -> dict[str, Floats]:
    """Return the columns of an episode: poses at 62.5 Hz, a raw wrench at 250 Hz, noise and an offset."""
    n = len(rows)
    pose = rows[:, 1:4] + rng.normal(size=(n, 3)) * NOISE["pose"]
    reading = rows[:, 4:] + [2.0, -1.0, 0.3] + rng.normal(size=(n, 3)) * [0.4, 0.4, 0.05]
    cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    grasp = np.column_stack([cos * GRASP[0] - sin * GRASP[1], sin * GRASP[0] + cos * GRASP[1]])
    gripper = np.column_stack([pose[:, :2] + grasp, pose[:, 2]])
    columns = {"t": rows[:, 0]}
    for k, axis in enumerate(("x", "y", "theta")):
        for name, values in (("object", pose), ("gripper", gripper)):
            columns[f"{name}_{axis}"] = np.where(np.arange(n) % 4 == 0, values[:, k], np.nan)
    for k, name in enumerate(("force_x", "force_y", "torque_z")):
        columns[name] = reading[:, k]
    return columns


PARAMETERS = {
    "mass": {"start": 15.0, "unit": "kg"},
    "rolling": {"start": 5.0, "unit": "N·s/m"},
    "turning": {"start": 1.0, "unit": "N·m·s/rad"},
}


def main() -> trundle.Diagnosis:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", help="output folder of the diagnosis")
    parser.add_argument("--episodes", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=6.0)
    args = parser.parse_args()
    recording = simulate_recording(dragging_foot((0.45, 0.3), 9.0), args.episodes, args.seconds)
    found = trundle.diagnose(recording, step=Table().step, parameters=PARAMETERS)
    print(found.verdict)
    for effect in found.answer["missing"]:
        print(f"{effect['effect']} (probability {effect['probability']:.2f}): {effect['statement']}")
    for name, value in found.answer["nominal"]["after"].items():
        text = (
            f"{value['mean']:.2f} ± {value['sd']:.2f}"
            if value["identifiable"]
            else "not identifiable from these data"
        )
        print(f"{name}: {text} {value['unit']}")
    before, after = (found.answer["fit"]["held_out"][key]["position_rmse"] for key in ("before", "after"))
    print(f"held out, open loop: {before:.4f} m -> {after:.4f} m")
    if args.out:
        print(f"report: {found.write(args.out) / 'report.html'}")
    return found


if __name__ == "__main__":
    main()
