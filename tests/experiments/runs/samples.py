"""Invented histories: a table passes a box; a wheel and, in one case, dry friction are estimated."""

from __future__ import annotations

import math
from typing import Any

from trundle.experiments.runs.history import Episode, parse_history

__all__ = ["SAMPLES", "episode", "history"]

BODY = {
    "footprint": [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]],
    "support": [[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]],
}
WHEEL = {"kind": "viscous_wheel", "x": 0.5, "y": -0.3, "angle": 0.4, "mu_x": 80.0, "mu_y": 120.0}
FRICTION = {"kind": "coulomb_friction", "x": -0.4, "y": 0.25, "force": 20.0}
LAWLESS: dict[str, Any] = {
    "estimate": [],
    "named": [],
    "supposed": [],
    "regrasp": None,
    "model": {"body": BODY},
}
"""Belief of a regression."""
BOX = [[0.9, -0.2], [1.1, -0.2], [1.1, 0.2], [0.9, 0.2]]


def history(
    pushes: int = 6,
    *,
    friction: bool = False,
    success: bool = True,
    lawless: bool = False,
    seed: int = 7,
) -> dict[str, Any]:
    """Return a history of half a second per push; the error of the estimate falls by a third each time."""
    rows = [step(0.05 * (k + 1), (k + 1) / (10 * pushes + 10)) for k in range(10 * pushes + 10)]
    return {
        "format": "trundle-run-history/1",
        "version": "0",
        "seed": seed,
        "object": {**BODY, "dof": ["x", "y", "theta"]},
        "scene": {"obstacle": [{"polygon": BOX}]},
        "control": 0.05,
        "first": {name: step(0.0, 0.0)[name] for name in ("pose", "goal", "wrench", "grasp")},
        "steps": rows,
        "updates": [
            LAWLESS | {"time": 0.5 * (k + 1)}
            if lawless
            else update(k + 1, friction and k >= 2, friction and k == 2)
            for k in range(pushes)
        ],
        "truth": {"body": {**BODY, "mass": 22.0}, "effect": [WHEEL, *([FRICTION] if friction else [])]},
        "outcome": {
            "is_success": success,
            "lost": False,
            "touched": 0,
            "seconds": rows[-1]["t"],
            "return": -3.0,
            "distance": 0.02 if success else 0.4,
            "heading_error": 0.01,
        },
    }


def step(t: float, share: float) -> dict[str, Any]:
    """Return a row of the motion."""
    return {
        "t": t,
        "pose": [2.0 * share, 0.8 * math.sin(math.pi * share), share],
        "goal": [2.0, 0.0, 1.0],
        "wrench": [60.0 * math.cos(4.0 * share), 30.0 * math.sin(6.0 * share), 10.0],
        "grasp": [-0.6, 0.0],
        "distance": 2.0 * (1.0 - share),
        "heading_error": 1.0 - share,
        "touched": False,
        "action": [60.0, 0.0, 10.0],
    }


def update(number: int, friction: bool, named: bool) -> dict[str, Any]:
    """Return the belief after a push: y and the drag across are not identifiable at first."""
    off = 0.2 / 3.0**number + 3e-4
    wheel = {**WHEEL, "x": 0.5 + off, "y": -0.3 - off, "mu_x": 80.0 + 90.0 * off, "mu_y": 120.0 - 90.0 * off}
    names = ["x", "mu_x"] if number == 1 else ["x", "y", "angle", "mu_x", "mu_y"]
    sds = {"x": off, "y": off, "angle": off, "mu_x": 90.0 * off, "mu_y": 90.0 * off}
    estimate = [{"name": "body.mass", "mean": 22.0 + 3.0 * off, "sd": 3.0 * off, "unit": "kg"}]
    estimate += [
        {
            "name": f"viscous_wheel.{name}",
            "mean": wheel[name] if name in names else None,
            "sd": sd if name in names else None,
            "unit": {"angle": "rad", "mu_x": "N·s/m", "mu_y": "N·s/m"}.get(name, "m"),
        }
        for name, sd in sds.items()
    ]
    if friction:
        estimate += [
            {"name": f"coulomb_friction.{name}", "mean": FRICTION[name], "sd": off, "unit": unit}
            for name, unit in (("x", "m"), ("y", "m"), ("force", "N"))
        ]
    return {
        "time": 0.5 * number,
        "estimate": estimate,
        "named": ["coulomb_friction"] if named else [],
        "supposed": [],
        "regrasp": [0.0, 0.4] if named else None,
        "model": {
            "body": {**BODY, "mass": 22.0},
            "effect": [wheel, *([FRICTION] if friction else [])],
            "posterior": {
                "names": [f"viscous_wheel.{name}" for name in names],
                "mean": [wheel[name] for name in names],
                "covariance": [[sds[a] ** 2 if a == b else 0.0 for b in names] for a in names],
            },
        },
    }


def episode(**given: Any) -> Episode:
    """Return a history as arrays."""
    return parse_history(history(**given))


SAMPLES: dict[str, list[dict[str, Any]]] = {
    "found": [{}],
    "friction": [{"friction": True}],
    "failed": [{"pushes": 2, "success": False}],
    "unlearnt": [{"pushes": 0, "success": False}],
    "lawless": [{"lawless": True}],
    "long": [{"pushes": 28, "friction": True}],
    "several": [{}, {"friction": True, "seed": 8}, {"pushes": 2, "success": False, "seed": 9}],
}
"""Histories of the tested pages."""
