"""The force-torque pipeline against MuJoCo's frames and its force and torque sensors.

A tilted gripper on a driven wrist grasps a free table by a weld. MuJoCo's sensors give the wrench of the
wrist on the gripper (parent on child) in sensor axes, which pushes the table, carries the weight of the
gripper and accelerates it. The wrench on the table follows from its acceleration.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

import trundle

Floats = NDArray[np.float64]

TABLE_MASS, TABLE_INERTIA = 20.0, 3.0
GRIPPER_MASS, GRIPPER_COM = 1.2, np.array([0.01, -0.02, 0.06])
OFFSET = np.array([3.0, -2.0, 8.0, 0.4, -0.3, 0.2])
FREE_TILT, HOLDING_TILT = np.array([0.15, -0.1]), np.array([-0.3, 0.4])
"""Pitch and roll when the tare is taken and when the table is held, rad."""
GRASPED = 1.2
"""When the weld closes, s."""
SCENE = f"""
<mujoco>
  <compiler angle="radian"/>
  <option timestep="5e-4" integrator="implicitfast"/>
  <worldbody>
    <body name="table">
      <joint name="tx" type="slide" axis="1 0 0"/>
      <joint name="ty" type="slide" axis="0 1 0"/>
      <joint name="ta" type="hinge" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="{TABLE_MASS}" diaginertia="1 3 {TABLE_INERTIA}"/>
    </body>
    <body name="wrist" pos="0.6 0.1 0.8">
      <joint name="x" type="slide" axis="1 0 0"/>
      <joint name="y" type="slide" axis="0 1 0"/>
      <joint name="yaw" type="hinge" axis="0 0 1"/>
      <joint name="pitch" type="hinge" axis="0 1 0" ref="{HOLDING_TILT[0]}"/>
      <joint name="roll" type="hinge" axis="1 0 0" ref="{HOLDING_TILT[1]}"/>
      <inertial pos="0 0 0" mass="2" diaginertia="0.02 0.02 0.02"/>
      <body name="gripper" pos="0 0 0.05">
        <inertial pos="{" ".join(map(str, GRIPPER_COM))}" mass="{GRIPPER_MASS}" diaginertia="1e-7 1e-7 1e-7"/>
        <site name="sensor"/>
        <site name="com" pos="{" ".join(map(str, GRIPPER_COM))}"/>
      </body>
    </body>
  </worldbody>
  <equality><weld name="grasp" body1="gripper" body2="table" active="false" solref="0.004 1"/></equality>
  <actuator>
    <position joint="x" kp="2e4" kv="800"/><position joint="y" kp="2e4" kv="800"/>
    <position joint="yaw" kp="2e3" kv="80"/>
    <position joint="pitch" kp="2e3" kv="80"/><position joint="roll" kp="2e3" kv="80"/>
  </actuator>
  <sensor>
    <force site="sensor"/><torque site="sensor"/>
    <framelinacc objtype="site" objname="com"/>
  </sensor>
</mujoco>
"""


def scene() -> mujoco.MjModel:
    """Return the scene, the wrist turned so that the weld is taken at the tilt at which it will close."""
    spec = mujoco.MjSpec.from_string(SCENE)
    pitch, roll = HOLDING_TILT
    wrist = spec.body("wrist")
    quaternion = np.zeros(4)
    by_pitch, by_roll = np.zeros(4), np.zeros(4)
    mujoco.mju_axisAngle2Quat(by_pitch, np.array([0.0, 1.0, 0.0]), pitch)
    mujoco.mju_axisAngle2Quat(by_roll, np.array([1.0, 0.0, 0.0]), roll)
    mujoco.mju_mulQuat(quaternion, by_pitch, by_roll)
    # Axes of the outer joints stay those of the world although the body is turned.
    back = np.zeros(4)
    mujoco.mju_negQuat(back, quaternion)
    wrist.quat = quaternion
    for name, axis in (("x", [1.0, 0, 0]), ("y", [0, 1.0, 0]), ("yaw", [0, 0, 1.0]), ("pitch", [0, 1.0, 0])):
        turned = np.zeros(3)
        mujoco.mju_rotVecQuat(turned, np.array(axis), back)
        spec.joint(name).axis = turned
    return spec.compile()


def target(t: float) -> Floats:
    """Where the wrist is driven: x, y, yaw, pitch, roll."""
    held = max(t - GRASPED, 0.0)
    share = np.clip((t - 0.5) / 0.4, 0.0, 1.0)
    tilt = FREE_TILT + (3 * share**2 - 2 * share**3) * (HOLDING_TILT - FREE_TILT)
    return np.array(
        [0.15 * (1 - np.cos(2 * held)), 0.1 * np.sin(held) * held, 0.3 * np.sin(1.5 * held) ** 2, *tilt]
    )


def run() -> tuple[dict[str, Floats], Floats]:
    """Return the columns of a recording, and the wrench [f_x, f_y, tau_z] on the table about its origin.

    World axes; the gripper's own inertia, which no tare takes off, is added to it.
    """
    model = scene()
    data = mujoco.MjData(model)
    data.qpos[3:8] = target(0.0)
    rows, truth = [], []
    for step in range(6000):
        data.ctrl[:] = target(data.time)
        data.eq_active[0] = data.time >= GRASPED
        mujoco.mj_forward(model, data)
        if step % 20 == 0:
            rows.append(
                [data.time, *data.qpos[:3], *data.site("sensor").xpos, *attitude(data), *sensed(data)]
            )
            truth.append(on_table(data))
        mujoco.mj_step(model, data)
    table = np.array(rows)
    return {name: table[:, k] for k, name in enumerate(COLUMNS)}, np.array(truth)


COLUMNS = [
    "t",
    *("object_x", "object_y", "object_theta"),
    *("gripper_x", "gripper_y", "gripper_z", "gripper_qw", "gripper_qx", "gripper_qy", "gripper_qz"),
    *("force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"),
]


def attitude(data: mujoco.MjData) -> Floats:
    """Quaternion world-from-sensor."""
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, data.site("sensor").xmat)
    return quaternion


def sensed(data: mujoco.MjData) -> Floats:
    """MuJoCo's sensors, with an offset."""
    reading: Floats = data.sensordata[:6] + OFFSET
    return reading


def on_table(data: mujoco.MjData) -> Floats:
    """Mass times acceleration of the table, and of the gripper, about the table's origin."""
    force_x, force_y = TABLE_MASS * data.qacc[:2]
    torque = TABLE_INERTIA * data.qacc[2]
    inertia = GRIPPER_MASS * data.sensordata[6:9]
    arm = data.site("com").xpos[:2] - data.qpos[:2]
    return np.array(
        [force_x + inertia[0], force_y + inertia[1], torque + arm[0] * inertia[1] - arm[1] * inertia[0]]
    )


def metadata(**wrench: Any) -> dict[str, Any]:
    return {
        "format": "trundle-recording/1",
        "name": "MuJoCo's table",
        "object": {"footprint": [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]},
        "wrench": {"frame": "sensor", "sign": "on_object", "raw": True, "precontact": [0.2, 0.45], **wrench},
    }


@pytest.fixture(scope="module")
def simulated() -> tuple[dict[str, Floats], Floats]:
    return run()


def test_the_wrench_on_the_object_is_its_mass_times_acceleration(
    simulated: tuple[dict[str, Floats], Floats],
) -> None:
    columns, truth = simulated
    described = metadata(gripper_mass=GRIPPER_MASS, gripper_com=GRIPPER_COM.tolist())
    prepared = trundle.prepare(trundle.Recording(described, {"push": columns}))["push"]
    theta = columns["object_theta"]
    force = prepared["on_object"]
    world = np.column_stack(
        [
            np.cos(theta) * force[:, 0] - np.sin(theta) * force[:, 1],
            np.sin(theta) * force[:, 0] + np.cos(theta) * force[:, 1],
            force[:, 2],
        ]
    )
    held = columns["t"] > GRASPED + 0.1
    assert np.ptp(truth[held], axis=0).min() > 3.0  # there is something to compare
    assert np.abs(world - truth)[held].max() < 0.02


def test_equation_12_has_the_error_of_the_rotated_offset(
    simulated: tuple[dict[str, Floats], Floats],
) -> None:
    columns, _ = simulated
    described = metadata(gripper_mass=GRIPPER_MASS, gripper_com=GRIPPER_COM.tolist())
    recording = trundle.Recording(described, {"push": columns})
    right = trundle.prepare(recording)["push"]["reading"]
    turned = trundle.prepare(recording, tare="equation_12")["push"]["reading"]
    assert np.abs(turned - right)[-1].max() > 1.0


def test_without_the_weight_a_tilting_gripper_is_refused(simulated: tuple[dict[str, Floats], Floats]) -> None:
    with pytest.raises(trundle.TrundleError, match="gripper_mass"):
        trundle.prepare(trundle.Recording(metadata(), {"push": simulated[0]}))
