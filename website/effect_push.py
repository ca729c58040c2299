"""The push of an effect's figure, simulated with and without the effect, and the residual wrench."""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from numpy.typing import NDArray

import trundle
from trundle.export import Laws

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["GRASP", "WHEEL_POSITION", "Motion", "effect_values", "residual", "simulate"]

ROOT = Path(__file__).resolve().parents[1]
OBJECT = ROOT / "configs" / "objects" / "office_table.toml"
GRASP = (-0.6, 0.1)
RATE_HZ = 250.0
WHEEL_POSITION = (-0.5, 0.3)
WHEEL = {
    "kind": "viscous_wheel",
    "x": WHEEL_POSITION[0],
    "y": WHEEL_POSITION[1],
    "angle": 0.3,
    "mu_x": 30.0,
    "mu_y": 90.0,
}
"""The locked wheel of the nominal model."""
KNOTS = [
    [0.0, 0.0, 0.0, 0.0],
    [0.3, 32.0, 0.0, 1.0],
    [1.8, 32.0, 4.0, 4.0],
    [2.2, -10.0, -20.0, -16.0],
    [3.4, -10.0, -20.0, -8.0],
    [3.8, -34.0, 10.0, 10.0],
    [5.0, -34.0, 10.0, 2.0],
    [5.3, 20.0, 8.0, 4.0],
    [6.0, 20.0, 8.0, 4.0],
]
"""Commanded wrench of the gripper: time, forces along the object's axes, torque (s, N, N, N·m)."""

VALUES: dict[str, dict[str, float]] = {
    "viscous_wheel": {"x": 0.5, "y": -0.3, "angle": 0.0, "mu_x": 20.0, "mu_y": 60.0},
    "coulomb_friction": {"x": 0.5, "y": -0.3, "force": 8.0},
    "support_friction": {"force": 12.0, "spread": 1.0},
    "support_drag": {"mu": 25.0, "spread": 1.0},
    "directional_friction": {"angle": 0.0, "difference": 25.0},
    "force_bias": {"force_x": 3.0, "force_y": -2.0, "torque_z": 0.5, "drift_x": 0.5},
    "floor_slope": {"accel_x": 0.25, "accel_y": -0.15},
    "com_offset": {"com_x": 0.2, "com_y": -0.12},
    "mass_spread": {"inertia_factor": 3.0},
    "mass_change": {"time": 3.0, "mass": 8.0},
    "wheel_event": {"time": 3.0, "factor_x": 3.0, "factor_y": 3.0},
    "force_scale": {"gain_x": 1.25, "gain_y": 0.8, "gain_torque": 1.0},
    "latency": {"delay": 0.08},
    "tracker_offset": {"offset_x": 0.08, "offset_y": -0.05, "offset_theta": 0.1},
    "cogging": {"amplitude": 8.0, "period": 0.15, "phase": 0.0, "angle": 0.0},
    "floor_patch": {
        "x": 0.95,
        "y": 0.0,
        "half_length": 0.25,
        "half_width": 0.6,
        "angle": 0.2,
        "mu": 40.0,
    },
    "floor_grain": {"mu": 40.0, "angle": 0.6},
    "tether": {
        "x": -0.5,
        "y": -0.3,
        "anchor_x": -1.2,
        "anchor_y": -0.3,
        "stiffness": 60.0,
        "rest_length": 0.9,
    },
    "obstacle_contact": {"x": 1.0, "y": 0.15},
    "caster_swivel": {"x": 0.5, "y": -0.3, "trail": 0.05, "mu_side": 60.0},
    "swinging_load": {"x": 0.3, "y": 0.2, "mass": 6.0, "frequency": 1.2},
    "doorsill": {"angle": 0.1, "offset": 0.8, "height": 0.01},
    "axis_friction": {"angle": 0.0, "force_x": 10.0, "force_y": 4.0, "torque": 1.0},
    "body_axis_friction": {"angle": 0.0, "force_x": 10.0, "force_y": 4.0, "torque": 1.0},
    "thinning_drag": {"force": 8.0, "exponent": 0.4, "spread": 1.0},
    "cross_talk": {"x_from_y": 0.2, "y_from_x": -0.2, "torque_from_x": 0.05},
    "saturation": {"limit_x": 22.0, "limit_y": 20.0, "limit_torque": 100.0, "excess": 0.3},
    "dead_band": {"force": 4.0, "torque": 0.4},
    "sensor_play": {"force": 4.0, "torque": 0.4},
    "clock_drift": {"drift": 0.02},
    "sensor_lag": {"time_constant": 0.1},
    "drive_lag": {"time_constant": 0.1},
}
"""Values of the figures. Other effects have the values of their priors."""


@dataclass(frozen=True)
class Motion:
    """A recorded push without noise; n samples.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Time since the gripper pushes, s.
    pose : ndarray, shape (n, 3)
        Recorded pose, world frame, m, m, rad.
    reading : ndarray, shape (n, 3)
        Recorded wrench on the object, object axes about its origin, N, N, N·m.
    """

    t: NDArray[np.float64]
    pose: NDArray[np.float64]
    reading: NDArray[np.float64]


def effect_values(effect: dict[str, Any]) -> dict[str, float]:
    """Return the parameter values of an effect's figure."""
    given = VALUES.get(effect["kind"], {})
    values = {}
    for parameter in effect["parameters"]:
        name = parameter["name"]
        if name in given or parameter["default"] is None:
            values[name] = given.get(name, prior_value(parameter))
    return values


def prior_value(parameter: dict[str, Any]) -> float:
    """Return a typical value under the prior of a parameter."""
    prior = parameter["prior"]
    match prior["distribution"]:
        case "normal":
            return float(prior["mean"] or prior["sd"])
        case "log_normal":
            return float(prior["median"])
        case "uniform":
            return float((parameter["lower"] + parameter["upper"]) / 2)
        case _:
            return 0.2


@cache
def simulate(*effect: tuple[str, Any]) -> Motion:
    """Simulate the push with the nominal model and an effect, given as the items of its table."""
    scenario = {
        "format": "trundle-scenario/1",
        "name": "figure",
        "object": str(OBJECT),
        "step": 1e-3,
        "effect": [WHEEL, *([dict(effect)] if effect else [])],
        "tracker": {"rate": RATE_HZ, "noise": [0.0, 0.0, 0.0]},
        "sensor": {"rate": RATE_HZ, "force_noise": 0.0, "torque_noise": 0.0},
        "push": [{"grasp": [*GRASP, 0.0], "drive": "force", "knots": KNOTS}],
    }
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scenario.toml"
        path.write_text(tomli_w.dumps(scenario), encoding="utf-8")
        (columns,) = trundle.simulate(path, seed=1).episodes.values()
    contact = columns["t"][-1] - KNOTS[-1][0]
    reading = np.column_stack([columns[name] for name in ("force_x", "force_y", "torque_z")])
    reading[:, 2] += GRASP[0] * reading[:, 1] - GRASP[1] * reading[:, 0]
    pose = np.column_stack([columns[f"object_{axis}"] for axis in ("x", "y", "theta")])
    pose[:, 2] = np.unwrap(pose[:, 2])
    return Motion(columns["t"] - contact, pose, reading)


def residual(motion: Motion) -> NDArray[np.float64]:
    """Return the wrench that is missing from the nominal model, shape (n, 3), object axes, N, N, N·m.

    It is `M a - (reading + laws)`: what would have to act in addition for the nominal model to move as
    recorded.
    """
    laws = Laws(trundle.Model.from_toml(nominal_model()))
    twist = np.gradient(motion.pose, motion.t, axis=0)
    acceleration = np.gradient(twist, motion.t, axis=0)
    known = np.array([laws.wrench(*state) for state in zip(motion.pose, twist, strict=True)])
    cos, sin = np.cos(motion.pose[:, 2]), np.sin(motion.pose[:, 2])
    ax, ay, spin = acceleration.T
    inertial = np.column_stack(
        [laws.mass * (cos * ax + sin * ay), laws.mass * (cos * ay - sin * ax), laws.inertia * spin]
    )
    return np.asarray(inertial - known - motion.reading)


def nominal_model() -> str:
    """Return the nominal model as the text of a `model.toml`."""
    bare = tomllib.loads(trundle.objects.read(OBJECT).bare.to_toml())
    return tomli_w.dumps({**bare, "effect": [WHEEL]})
