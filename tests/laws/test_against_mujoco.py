"""Laws compared with MuJoCo mechanisms: joints, a tendon, a contact, a hinged wheel."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

import trundle

Floats = NDArray[np.float64]

MASS, INERTIA = 20.0, 3.5
DRAG, SPIN = 25.0, 3.0
"""Viscous drag at the origin, N·s/m, and of the spin, N·m·s."""
SECONDS, SAMPLE, STEP = 3.0, 0.01, 2e-4


def push(t: float) -> Floats:
    """Return a push back and forth off the mass centre, object axes about the object origin."""
    return np.array([30.0 * np.sin(2.2 * t), 12.0 * np.sin(3.0 * t), 4.0 * np.cos(2.0 * t)])


def forwards(t: float) -> Floats:
    """Return a push mostly along x."""
    return np.array([20.0, 4.0 * np.sin(2.0 * t), 1.5 * np.sin(3.0 * t)])


def engine(
    inside: str,
    outside: str = "",
    *,
    mass: float = MASS,
    inertia: float = INERTIA,
    wrench: Callable[[float], Floats] = push,
    start: float | None = None,
) -> Floats:
    """Poses of a planar table after each sample; `inside` is in its body, `outside` in the world
    beside it, `start` where the first joint inside begins."""
    world, _, rest = outside.partition("<!-- rest -->")
    model = mujoco.MjModel.from_xml_string(
        f"""
        <mujoco>
          <option timestep="{STEP}" gravity="0 0 0" integrator="implicit"/>
          <worldbody>
            {world}
            <body name="table">
              <joint type="slide" axis="1 0 0" damping="{DRAG}"/>
              <joint type="slide" axis="0 1 0" damping="{DRAG}"/>
              <joint type="hinge" axis="0 0 1" damping="{SPIN}"/>
              <inertial pos="0 0 0" mass="{mass}" diaginertia="1 3 {inertia}"/>
              {inside}
            </body>
          </worldbody>
          {rest}
        </mujoco>
        """
    )
    data = mujoco.MjData(model)
    if start is not None:
        data.qpos[3] = start
    poses = []
    for tick in range(round(SECONDS / STEP)):
        force_x, force_y, torque = wrench((tick + 0.5) * STEP)
        sin, cos = np.sin(data.qpos[2]), np.cos(data.qpos[2])
        data.qfrc_applied[:3] = [cos * force_x - sin * force_y, sin * force_x + cos * force_y, torque]
        mujoco.mj_step(model, data)
        if (tick + 1) % round(SAMPLE / STEP) == 0:
            poses.append(data.qpos[:3].copy())
    return np.array(poses)


def laws(effect: str, wrench: Callable[[float], Floats] = push, inner: list[float] | None = None) -> Floats:
    """Return the poses of the same table with a law instead."""
    model = trundle.Model.from_toml(
        f"""
        format = "trundle-model/1"
        [body]
        footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
        mass = {MASS}
        inertia = {INERTIA}
        [[effect]]
        kind = "viscous_wheel"
        x = 0
        y = 0
        angle = 0
        mu_x = {DRAG}
        mu_y = {DRAG}
        [[effect]]
        kind = "spin_drag"
        spin = {SPIN}
        [[effect]]
        {effect}
        """
    )
    t = np.arange(0.0, SECONDS + SAMPLE / 2, SAMPLE)
    poses, _ = model.rollout([0, 0, 0], [0, 0, 0], t, np.array([wrench(s) for s in t]), inner=inner)
    return poses[1:]


def gap(one: Floats, other: Floats) -> tuple[float, float]:
    """Return the largest difference in position, m, and in heading, rad."""
    return float(np.hypot(*(one - other)[:, :2].T).max()), float(np.abs((one - other)[:, 2]).max())


def assert_alike(law: Floats, expected: Floats, without: Floats, position: float, heading: float) -> None:
    """Assert that poses agree, and that the effect is twenty times as large."""
    off = gap(law, expected)
    assert off[0] < position and off[1] < heading, off
    effect = gap(without, expected)
    assert effect[0] > 20 * position or effect[1] > 20 * heading, (off, effect)


@pytest.fixture(scope="module")
def bare() -> Callable[[Callable[[float], Floats]], Floats]:
    """Return the poses of the table without an effect."""
    return lambda wrench: engine("", wrench=wrench)


Bare = Callable[[Callable[[float], Floats]], Floats]


def test_swinging_load(bare: Bare) -> None:
    mass, frequency, ratio, at = 5.0, 1.4, 0.05, (0.3, -0.2)
    omega = 2 * np.pi * frequency
    slide = f'stiffness="{mass * omega**2}" damping="{2 * ratio * mass * omega}"'
    load = f"""
    <body pos="{at[0]} {at[1]} 0">
      <joint type="slide" axis="1 0 0" {slide}/><joint type="slide" axis="0 1 0" {slide}/>
      <inertial pos="0 0 0" mass="{mass}" diaginertia="1e-6 1e-6 1e-6"/>
    </body>"""
    left = (MASS - mass) / MASS
    expected = engine(load, mass=MASS * left, inertia=INERTIA * left)
    law = laws(
        f"""kind = "swinging_load"
        x = {at[0]}
        y = {at[1]}
        mass = {mass}
        frequency = {frequency}
        damping_ratio = {ratio}"""
    )
    assert_alike(law, expected, bare(push), 2e-4, 2e-4)


def test_tether(bare: Bare) -> None:
    stiffness, rest, at, anchor = 120.0, 0.5, (0.5, 0.3), (0.1, 0.5)
    ends = f"""<site name="anchor" pos="{anchor[0]} {anchor[1]} 0"/><!-- rest -->
    <tendon><spatial stiffness="{stiffness}" springlength="0 {rest}">
      <site site="anchor"/><site site="tied"/>
    </spatial></tendon>"""
    expected = engine(f'<site name="tied" pos="{at[0]} {at[1]} 0"/>', ends)
    law = laws(
        f"""kind = "tether"
        x = {at[0]}
        y = {at[1]}
        anchor_x = {anchor[0]}
        anchor_y = {anchor[1]}
        stiffness = {stiffness}
        rest_length = {rest}"""
    )
    assert_alike(law, expected, bare(push), 3e-4, 3e-4)


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_obstacle_contact(bare: Bare, friction: float) -> None:
    at, radius = (0.85, 0.15), 0.05
    cone = (
        f'friction="{friction} 0 0" condim="{3 if friction else 1}" solref="0.004 1" solimp="0.99 0.99 0.001"'
    )
    post = f'<geom type="cylinder" size="{radius} 0.5" pos="{at[0]} {at[1]} 0" {cone}/>'
    expected = engine(f'<geom type="box" size="0.6 0.4 0.1" {cone}/>', post, wrench=forwards)
    law = laws(
        f"""kind = "obstacle_contact"
        x = {at[0]}
        y = {at[1]}
        radius = {radius}
        friction = {friction}""",
        forwards,
    )
    # The obstacle yields by a millimetre, MuJoCo's hardly.
    assert_alike(law, expected, bare(forwards), 8e-3, 8e-3)


@pytest.mark.parametrize("first", [0.0, 2.5])
def test_caster_swivel(bare: Bare, first: float) -> None:
    at, trail, side = (0.5, -0.3), 0.06, 60.0
    # A grip that does not let the wheel slip, and the scrubbing on the floor that makes this side force.
    grip, scrub = 1e5, side * trail**2
    caster = f"""
    <body name="caster" pos="{at[0]} {at[1]} 0">
      <joint name="swivel" type="hinge" axis="0 0 1"/>
      <inertial pos="{-trail} 0 0" mass="1e-3" diaginertia="1e-6 1e-6 1e-6"/>
      <site name="wheel" pos="{-trail} 0 0"/>
    </body>"""
    brakes = f"""<!-- rest --><actuator>
      <general site="wheel" gear="0 1 0 0 0 0" gainprm="0" biastype="affine" biasprm="0 0 {-grip}"/>
      <general site="wheel" gear="0 0 0 0 0 1" gainprm="0" biastype="affine" biasprm="0 0 {-scrub}"/>
    </actuator>"""
    expected = engine(caster, brakes, start=first)
    law = laws(
        f"""kind = "caster_swivel"
        x = {at[0]}
        y = {at[1]}
        trail = {trail}
        mu_side = {side}""",
        inner=[first],
    )
    assert_alike(law, expected, bare(push), 5e-4, 5e-4)
