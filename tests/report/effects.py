"""An invented diagnosis for each effect, with the keys that it may contain."""

from __future__ import annotations

import copy
from typing import Any

from tests.report.answers import Sample, measure, table_sample

Parameters = dict[str, dict[str, Any]]

BODY = {"body_point": {"mean": [-0.48, 0.31], "sd": [0.02, 0.03]}}
WORLD = {"world_point": {"mean": [1.6, 0.9], "sd": [0.05, 0.02]}}
REGION = {"world_region": [[0.5, -0.4], [1.4, -0.2], [1.5, 0.7], [0.6, 0.6]]}
EVENT = {"event": {"episode": "episode_05", "time": {"mean": 2.31, "sd": 0.02}}}
DAMPING = [[15.2, 0.5, -3.1], [0.5, 180.4, 22.0], [-3.1, 22.0, 44.7]]


def damping() -> dict[str, Any]:
    """A matrix with its intervals."""
    return measure_matrix(DAMPING, 0.03)


def measure_matrix(mean: list[list[float]], share: float) -> dict[str, Any]:
    sd = [[max(0.1, share * abs(value)) for value in row] for row in mean]
    return {"mean": mean, "sd": sd, "unit": "N·s/m", "identifiable": True}


EFFECTS: dict[str, tuple[Parameters, dict[str, Any] | None]] = {
    "coulomb_friction": (
        {"force": measure(14.2, 0.3, "N"), "static_force": measure(17.0, 0.8, "N")},
        BODY,
    ),
    "caster_swivel": ({"trail": measure(0.042, 0.003, "m"), "mu_side": measure(81.0, 4.0, "N·s/m")}, BODY),
    "second_wheel": ({"damping": damping()}, None),
    "com_offset": ({"com_x": measure(-0.11, 0.01, "m"), "com_y": measure(0.05, 0.008, "m")}, BODY),
    "mass_spread": ({"inertia_factor": measure(1.62, 0.03, "1")}, None),
    "floor_slope": ({"accel_x": measure(0.21, 0.01, "m/s²"), "accel_y": measure(-0.1, 0.01, "m/s²")}, {}),
    "floor_patch": ({"mu": measure(48.0, 3.0, "N·s/m")}, REGION),
    "floor_grain": ({"mu": measure(35.0, 2.0, "N·s/m"), "angle": measure(0.6, 0.04, "rad")}, None),
    "wheel_event": ({"factor_x": measure(8.1, 0.4, "1"), "factor_y": measure(1.02, 0.03, "1")}, EVENT),
    "mass_change": ({"mass": measure(-5.2, 0.2, "kg")}, EVENT),
    "obstacle_contact": ({}, WORLD),
    "tether": (
        {"stiffness": measure(62.0, 4.0, "N/m"), "rest_length": measure(0.7, 0.02, "m")},
        BODY | WORLD,
    ),
    "swinging_load": ({"mass": measure(4.1, 0.3, "kg"), "frequency": measure(0.83, 0.02, "Hz")}, BODY),
    "force_bias": (
        {
            "force_x": measure(-0.82, 0.05, "N"),
            "force_y": measure(0.3, 0.05, "N"),
            "torque_z": measure(0.01, 0.02, "N·m"),
            "drift_x": measure(0.02, 0.004, "N/s"),
            "drift_y": measure(None, None, "N/s", identifiable=False),
        },
        None,
    ),
    "force_scale": (
        {name: measure(0.9, 0.01, "1") for name in ("gain_x", "gain_y", "gain_torque")},
        None,
    ),
    "latency": ({"delay": measure(0.038, 0.002, "s")}, None),
    "gripper_inertia": ({"mass": measure(1.3, 0.1, "kg")}, None),
    "tracker_offset": (
        {
            "offset_x": measure(0.031, 0.002, "m"),
            "offset_y": measure(-0.012, 0.002, "m"),
            "offset_theta": measure(0.05, 0.004, "rad"),
        },
        None,
    ),
}


def effect_entry(name: str) -> dict[str, Any]:
    """An entry of `missing`."""
    parameters, where = EFFECTS[name]
    return {
        "effect": name,
        "probability": 0.97,
        "statement": f"What {name} does is said here in one sentence, 14.2 ± 0.3 N at (-0.48, 0.31) m.",
        "parameters": copy.deepcopy(parameters),
        "where": copy.deepcopy(where),
        "explains": 0.87,
    }


def effect_sample(*names: str) -> Sample:
    """An answer that names some effects."""
    diagnosis, series = table_sample()
    diagnosis["missing"] = [effect_entry(name) for name in names]
    series["candidates"][0]["effects"] = list(names)
    return diagnosis, series
