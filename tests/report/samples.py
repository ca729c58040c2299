"""Every kind of answer that a report must tell, by name."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.report.answers import (
    Sample,
    consistent_sample,
    quasi_static_sample,
    rail_sample,
    table_sample,
    tied_sample,
    unexplained_sample,
)
from tests.report.effects import EVENT, REGION, effect_entry, effect_sample

CHECK = "cat recordings/table/* | sha256sum"


def push(profile: str, knots: list[list[float]], **more: Any) -> dict[str, Any]:
    """One push of an experiment."""
    return {
        "grasp": [-0.6, 0.3],
        "direction": -0.5,
        "start": [0.0, 0.0, 1.57],
        "profile": profile,
        "force": 20.0,
        "torque": 0.0,
        "duration": 6.0,
        "knots": knots,
        "separation": 31.0,
        "cumulative": 31.0,
        "sentence": "Grasp the object at (-0.60, 0.30) m (object frame) and push it 29° to the right of its "
        "x axis with 20 N for 1.5 s, then release it.",
        **more,
    }


def experiment(*models: str) -> dict[str, Any]:
    """Two pushes that tell two models apart: one along a line, one that turns."""
    t = np.linspace(0.0, 6.0, 61)
    forth = np.column_stack([t, 20.0 * np.sin(t), 0.0 * t, 0.0 * t])
    turn = np.column_stack([t, 0.0 * t, 0.0 * t, 3.0 * np.cos(2.0 * t)])
    return {
        "models": list(models),
        "pushes": [push("there_and_back", forth.tolist()), push("turn", turn.tolist(), grasp=[0.55, -0.3])],
        "separation": [44.0, 39.0],
        "recorded": 0.3,
        "sure": 0.99,
        "repeats": 1,
        "sentence": "First rotate the object by 90° to the left. Grasp the object at (-0.60, 0.30) m (object "
        "frame) and push it along its x axis with 20 N for 1.5 s. Then: Grasp the object at (0.55, -0.30) m "
        "(object frame) and rotate it with 3 N·m. The chance that the true model then has a probability "
        "above 0.95 is 99 %.",
    }


def certificate(*models: str) -> dict[str, Any]:
    """What states that two models are the same on what was recorded."""
    return {
        "models": list(models),
        "sigmas": 0.14,
        "same": True,
        "statement": f"{' and '.join(models)}: indistinguishable within noise. Over all training "
        "episodes their simulated trajectories differ by at most 0.1 mm and 0.01°, 0.14 standard deviations "
        "of the noise (largest in episode_00 at 1.20 s). Their log likelihoods differ by 0.3 nats.",
    }


def certified_sample() -> Sample:
    """A tie of three, with certificates and an experiment that can be drawn."""
    diagnosis, series = tied_sample()
    group = ["force_bias", "floor_slope", "floor_grain"]
    diagnosis |= {"tied": [group]}
    series["certificates"] = [certificate(*group[:2]), certificate(group[0], group[2])]
    series["experiments"] = [experiment(*group[:2])]
    series["input"] = [
        {"what": "recording", "sha256": "0123456789abcdef" * 4, "check": CHECK},
        {"what": "model", "sha256": "fedcba9876543210" * 4, "check": "sha256sum model.toml"},
    ]
    return diagnosis, series


def events_sample() -> Sample:
    """Two effects at nearly the same moment, a patch of the floor, and something at the very end."""
    diagnosis, series = effect_sample("wheel_event", "mass_change", "floor_patch", "mass_change")
    for index, time in ((1, 2.42), (3, 4.98)):
        event = {"episode": EVENT["event"]["episode"], "time": {"mean": time, "sd": 0.02}}
        diagnosis["missing"][index]["where"] = {"event": event}
    return diagnosis, series


def corners_sample() -> Sample:
    """Five effects at places close to each other and on the edge of the object."""
    diagnosis, series = table_sample()
    diagnosis["missing"] = [effect_entry("coulomb_friction") for _ in range(5)]
    for entry, x in zip(diagnosis["missing"], (-0.6, -0.58, -0.5, 0.6, 0.59), strict=True):
        entry["where"] = {"body_point": {"mean": [x, 0.4], "sd": [0.01, 0.01]}}
    return diagnosis, series


def foreign_sample() -> Sample:
    """Something without a name, tied to the floor, with a residual wrench that improves the fit."""
    diagnosis, series = unexplained_sample()
    diagnosis["mismatch"] = diagnosis["mismatch"] | {"body_point": None, **REGION}
    return diagnosis, series | {"unnamed": ["the place in the room", "the heading"]}


def reparameterised_sample() -> Sample:
    """A model that gave the wrong mass."""
    diagnosis, series = table_sample()
    long = {f"viscous_wheel.{name}": value for name, value in diagnosis["nominal"]["before"].items()}
    given = {"mass": 30.0, "wheel_x": -0.4, "viscous_wheel.wheel_mu_x": 11.0}
    nominal = diagnosis["nominal"]
    diagnosis["nominal"] = {
        "given": given,
        "before": nominal["before"] | long,
        "after": nominal["after"] | long,
    }
    return diagnosis | {"verdict": "reparameterised", "missing": [], "alternatives": []}, series


SAMPLES = {
    "table": table_sample,
    "tied": tied_sample,
    "certified": certified_sample,
    "tether": lambda: effect_sample("tether"),
    "events": events_sample,
    "corners": corners_sample,
    "wheels": lambda: effect_sample("second_wheel", "latency"),
    "consistent": consistent_sample,
    "reparameterised": reparameterised_sample,
    "unexplained": unexplained_sample,
    "foreign": foreign_sample,
    "rail": rail_sample,
    "quasi_static": quasi_static_sample,
}
