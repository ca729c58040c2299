"""Small mechanisms, and motions of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

ARM = """<mujoco model="arm">
<compiler angle="radian"/>
<option gravity="0.3 -0.2 -9.7"/>
<worldbody>
  <body name="base" pos="0.1 0.2 0.3" euler="0.1 0.2 0.3">
    <geom type="box" size="0.1 0.1 0.1"/>
    <body name="upper" pos="0 0 0.2">
      <joint name="shoulder" axis="0.2 1 0.1" pos="0.05 0 -0.02" armature="0.02" damping="0.3"
             frictionloss="0.4" stiffness="1.5" springref="0.2"/>
      <inertial pos="0.02 0.01 0.15" mass="2.0" fullinertia="0.03 0.025 0.02 0.001 -0.002 0.003"/>
      <body name="wedge" pos="0.02 0 0.3" euler="0.3 0 0.1">
        <joint name="locked" axis="1 0 0" ref="0.2"/>
        <inertial pos="0.01 0 0" mass="0.3" diaginertia="0.001 0.002 0.002"/>
        <body name="rail" pos="0 0.05 0.1" gravcomp="0.4">
          <joint name="lift" type="slide" axis="0.1 0.2 1" ref="0.05" damping="2"/>
          <joint name="roll" axis="1 0.1 0" pos="0 0.02 0" armature="0.01" ref="-0.1"/>
          <inertial pos="0.1 0.02 0.03" mass="0.8" diaginertia="0.004 0.005 0.006"/>
          <body name="hand" pos="0.2 0 0.05" euler="0 0.4 0">
            <inertial pos="0 0.03 0.04" mass="0.25" diaginertia="0.0004 0.0005 0.0006"/>
            <body name="left" pos="0.05 0 0">
              <joint name="finger" type="slide" axis="0 1 0"/>
              <inertial pos="0.02 0 0.01" mass="0.1" diaginertia="0.0001 0.0001 0.0001"/>
            </body>
            <body name="right" pos="-0.05 0 0">
              <joint name="mimic" axis="0 0 1" ref="0.3" frictionloss="0.02"/>
              <inertial pos="0.03 0 0.02" mass="0.12" diaginertia="0.0001 0.0001 0.0001"/>
            </body>
          </body>
        </body>
      </body>
    </body>
  </body>
</worldbody>
<equality><joint joint1="mimic" joint2="finger" polycoef="0.05 3 2 0 0"/></equality>
<actuator><position name="servo" joint="roll" kp="50"/></actuator>
<sensor><jointpos joint="locked"/></sensor>
<keyframe><key qpos="0 0 0 0 0 0"/></keyframe>
</mujoco>"""
"""Hinges and slides off the origins of bodies, a joint to lock, fixed bodies, and a follower."""

JOINTS = ["lift", "shoulder", "roll", "finger"]
"""Recorded joints of `ARM`, in another order than the model's."""


def motion(count: int = 5, seed: int = 0, joints: int = len(JOINTS)) -> tuple[Floats, Floats, Floats]:
    """Return random positions, velocities and accelerations."""
    rng = np.random.default_rng(seed)
    return (
        rng.normal(size=(count, joints)) * 0.5,
        rng.normal(size=(count, joints)),
        rng.normal(size=(count, joints)) * 3,
    )
