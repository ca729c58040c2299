"""The integrator compared with MuJoCo's: a planar free body with viscous drag."""

from collections.abc import Callable

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

import trundle

MASS, INERTIA = 20.0, 3.5
DURATION, SAMPLE = 2.0, 0.01


def mujoco_poses(
    com: tuple[float, float], drag: tuple[float, float, float], wrench: Callable[[float], NDArray[np.float64]]
) -> NDArray[np.float64]:
    """Poses after each sample; drag along world x, y and on the spin, at the object origin."""
    model = mujoco.MjModel.from_xml_string(
        f"""
        <mujoco>
          <option timestep="1e-4" gravity="0 0 0" integrator="RK4"/>
          <worldbody><body name="table">
            <joint type="slide" axis="1 0 0" damping="{drag[0]}"/>
            <joint type="slide" axis="0 1 0" damping="{drag[1]}"/>
            <joint type="hinge" axis="0 0 1" damping="{drag[2]}"/>
            <inertial pos="{com[0]} {com[1]} 0" mass="{MASS}" diaginertia="1 3 {INERTIA}"/>
          </body></worldbody>
        </mujoco>
        """
    )
    data = mujoco.MjData(model)
    per_sample = round(SAMPLE / model.opt.timestep)
    poses = []
    for step in range(round(DURATION / model.opt.timestep)):
        force_x, force_y, torque = wrench((step + 0.5) * model.opt.timestep)
        sin, cos = np.sin(data.qpos[2]), np.cos(data.qpos[2])
        data.qfrc_applied[:] = [cos * force_x - sin * force_y, sin * force_x + cos * force_y, torque]
        mujoco.mj_step(model, data)
        if (step + 1) % per_sample == 0:
            poses.append(data.qpos.copy())
    return np.array(poses)


def table(com: tuple[float, float], effects: str) -> trundle.Model:
    return trundle.Model.from_toml(
        f"""
        format = "trundle-model/1"
        [body]
        footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
        mass = {MASS}
        inertia = {INERTIA}
        com = [{com[0]}, {com[1]}]
        {effects}
        """
    )


def push(t: float) -> NDArray[np.float64]:
    """Return an oscillating push off the mass centre, which rotates the table by a radian or more."""
    return np.array([25.0, 12.0 * np.sin(3.0 * t), 6.0 + 4.0 * np.sin(2.0 * t)])


@pytest.mark.parametrize("com", [(0.0, 0.0), (0.2, -0.1)], ids=["centred", "off-centre"])
def test_isotropic_drag_at_the_origin(com: tuple[float, float]) -> None:
    wheel = '[[effect]]\nkind = "viscous_wheel"\nx = 0\ny = 0\nangle = 0.3\nmu_x = 30\nmu_y = 30\n'
    assert_agreement(com, wheel, (30.0, 30.0, 0.0))


@pytest.mark.parametrize("com", [(0.0, 0.0), (0.2, -0.1)], ids=["centred", "off-centre"])
def test_two_wheels_whose_drag_is_isotropic_with_spin_damping(com: tuple[float, float]) -> None:
    wheel = '[[effect]]\nkind = "viscous_wheel"\nx = {}\ny = {}\nangle = 0\nmu_x = 20\nmu_y = 20\n'
    pair = wheel.format(-0.5, -0.3) + wheel.format(0.5, 0.3)
    assert_agreement(com, pair, (40.0, 40.0, 40.0 * (0.5**2 + 0.3**2)))


def assert_agreement(com: tuple[float, float], effects: str, drag: tuple[float, float, float]) -> None:
    expected = mujoco_poses(com, drag, push)
    t = np.arange(0.0, DURATION + SAMPLE / 2, SAMPLE)
    poses, _ = table(com, effects).rollout([0, 0, 0], [0, 0, 0], t, np.array([push(s) for s in t]))
    assert abs(expected[-1, 2]) > 0.8
    # Both are accurate to far below 0.1 mm; MuJoCo holds the push constant over its step.
    np.testing.assert_allclose(poses[1:], expected, atol=1e-4)
