"""Masses and friction of a user's robot, from joint positions and efforts by linear regression.

Loads an MJCF model, computes the effort that it needs for a motion, and fits what the measured effort has in
addition: another mass, and dry friction at one joint. Needs `pip install 'trundle[mujoco]'`.

    python examples/mechanism_regressors.py [robot.xml JOINT JOINT ...]
"""

from __future__ import annotations

import sys

import numpy as np

from trundle.mechanism import Mechanism

ROBOT = """<mujoco>
<worldbody>
  <body name="upper">
    <joint name="shoulder" axis="0 1 0" armature="0.05" damping="0.2"/>
    <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03" mass="1.5"/>
    <body name="lower" pos="0.3 0 0">
      <joint name="elbow" axis="0 1 0" armature="0.02" damping="0.1"/>
      <geom type="capsule" fromto="0 0 0 0.25 0 0" size="0.02" mass="0.7"/>
    </body>
  </body>
</worldbody>
</mujoco>"""


def main(source: str = ROBOT, joints: tuple[str, ...] = ("shoulder", "elbow")) -> dict[str, float]:
    arm = Mechanism.load(source, joints, contacts=False)
    print(f"moving bodies: {', '.join(f'{name} {mass:.3g} kg' for name, mass in arm.masses.items())}")
    t = np.linspace(0.0, 10.0, 2001)
    rates = 1.0 + 0.7 * np.arange(len(joints))
    phase = t[:, None] * rates
    limits = np.clip(arm.ranges, -1.0, 1.0)  # also where a joint has no limits
    middle, size = limits.mean(axis=1), 0.3 * np.ptp(limits, axis=1)
    q, v, a = middle + size * np.sin(phase), size * rates * np.cos(phase), -size * rates**2 * np.sin(phase)

    # The "real" robot: its last body is 20 % heavier, and its last joint has dry friction.
    body = arm.bodies[-1]
    real = arm.adjusted(mass={body: 1.2 * arm.masses[body]})
    measured = real.inverse_dynamics(q, v, a)
    measured[:, -1] += 0.5 * np.sign(v[:, -1])
    measured += np.random.default_rng(0).normal(scale=0.02, size=measured.shape)

    found = arm.regressors(q, v, a, derivatives=False)
    columns = {f"mass:{name}": column.ravel() for name, column in found.mass.items()}
    for k, joint in enumerate(joints):
        column = np.zeros_like(measured)
        column[:, k] = np.sign(v[:, k])
        columns[f"dry friction:{joint}"] = column.ravel()
    design = np.column_stack(list(columns.values()))
    missing = (measured - found.effort).ravel()
    values, *_ = np.linalg.lstsq(design, missing, rcond=None)
    left = missing - design @ values
    print(f"rms of the missing effort: {missing.std():.3f} -> {left.std():.3f} N·m")
    changes = dict(zip(columns, values.tolist(), strict=True))
    for name, value in changes.items():
        print(f"{name}: {value:+.4f}")
    return changes


if __name__ == "__main__":
    main(sys.argv[1], tuple(sys.argv[2:])) if sys.argv[1:] else main()
