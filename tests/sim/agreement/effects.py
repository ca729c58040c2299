"""Effects of the catalogue with values that have an influence, and a push that shows it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import trundle
from tests.sim.agreement.scene import Effect, Push

CATALOGUE = {effect["kind"]: effect for effect in trundle.effects()}
ON_OBJECT = [kind for kind, effect in CATALOGUE.items() if effect["acting"] == "object"]
ON_INSTRUMENTS = [kind for kind, effect in CATALOGUE.items() if effect["acting"] == "instrument"]
STATELESS = [kind for kind in ON_OBJECT if not CATALOGUE[kind]["states"]]

WHEEL: Effect = {"kind": "viscous_wheel", "x": -0.2, "y": 0.1, "angle": 0.3, "mu_x": 25.0, "mu_y": 60.0}
"""Effects of every table."""

PUSH = Push(
    start=(0.3, -0.2, 0.5),
    grasp=(-0.6, 0.1, 0.2),
    knots=[
        (0.0, 0, 0, 0),
        (0.3, 45, 10, 4),
        (1.4, 40, -15, -6),
        (1.7, -35, 10, 5),
        (2.8, -40, 0, -4),
        (3.1, 20, 5, 2),
        (3.6, 0, 0, 0),
        (4.0, 0, 0, 0),
    ],
)
"""A push forward, back, and a release."""

VALUES: Mapping[str, Mapping[str, float]] = {
    "viscous_wheel": {"mu_x": 10.0, "mu_y": 50.0},
    "coulomb_friction": {"force": 14.0, "static_force": 18.0},
    "support_friction": {"force": 20.0, "static_force": 25.0},
    "directional_friction": {"difference": 15.0},
    "mass_spread": {"inertia_factor": 1.6},
    "mass_change": {"time": 1.2, "mass": 8.0},
    "wheel_event": {"time": 1.2, "factor_x": 4.0, "factor_y": 0.3},
    "cogging": {"period": 0.15},
    "floor_patch": {"x": 1.0, "y": 0.2},
    "tether": {"anchor_x": -1.0, "anchor_y": 0.4, "rest_length": 1.0, "damping": 3.0},
    "obstacle_contact": {"x": 1.3, "y": 0.3, "friction": 0.3},
    "doorsill": {"angle": 0.1, "offset": 0.9},
    "force_bias": {"force_x": 3.0, "force_y": -2.0, "torque_z": 0.8, "drift_x": 0.5, "drift_y": -0.3},
    "force_scale": {"gain_x": 1.1, "gain_y": 0.8, "gain_torque": 1.3},
    "latency": {"delay": 0.03},
    "axis_friction": {"force_x": 12.0, "force_y": 6.0},
    "body_axis_friction": {"force_x": 12.0, "force_y": 6.0},
    "cross_talk": {
        "x_from_y": 0.2,
        "x_from_torque": 0.5,
        "y_from_x": -0.1,
        "y_from_torque": 0.3,
        "torque_from_x": 0.05,
        "torque_from_y": -0.1,
    },
    "tracker_offset": {"offset_x": 0.1, "offset_y": -0.05, "offset_theta": 0.3},
}
"""In the place of usual ones, where those would not be met on the way or be too simple."""


def effect_of(kind: str) -> Effect:
    """Return an effect that shows: the usual values of its catalogue, some of them replaced."""
    usual = {p["name"]: typical(p["prior"]) for p in CATALOGUE[kind]["parameters"] if p["default"] is None}
    return {"kind": kind, **usual, **VALUES.get(kind, {})}


def typical(prior: Mapping[str, Any]) -> float:
    """Return a value that a parameter may well have, other than none."""
    match prior["distribution"]:
        case "on_body":
            return {"x": 0.3, "y": -0.2}[prior["axis"]]
        case "log_normal":
            return float(prior["median"])
        case "normal":
            return float(prior["mean"] + prior["sd"])
        case _:
            return 0.4
