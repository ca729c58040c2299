"""Sample diagnoses: a small table simulated in NumPy, with and without dry friction."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from tests.report.table import DRAG, DRAG_FORCE, FOOTPRINT, POSE_SD, SUPPORT, Array, episode

Sample = tuple[dict[str, Any], dict[str, Any]]


def measure(mean: float | None, sd: float | None, unit: str, **more: Any) -> dict[str, Any]:
    return {"mean": mean, "sd": sd, "unit": unit, **more}


def scores(before: float, after: float) -> dict[str, dict[str, float]]:
    keys = {
        "position_rmse": 1.0,
        "heading_rmse": 2.0,
        "final_position_error": 1.7,
        "final_heading_error": 2.4,
    }
    keys |= {
        "window_position_rmse": 0.06,
        "window_heading_rmse": 0.09,
        "force_rmse": 50.0,
        "torque_rmse": 20.0,
    }
    figures = {
        side: {key: size * value for key, size in keys.items()}
        for side, value in (("before", before), ("after", after))
    }
    figures["before"] |= {"r2": 0.86, "log_predictive_density": 9.1}
    figures["after"] |= {"r2": 0.9994, "log_predictive_density": 14.6}
    return figures


def table_sample(drag: float = DRAG_FORCE) -> Sample:
    """Dry friction at a point of a table with one wheel: six pushes, two of them held out."""
    series = {
        "footprint": [FOOTPRINT.tolist()],
        "support": SUPPORT.tolist(),
        "dof": ["x", "y", "theta"],
        "quasi_static": False,
        "command": "trundle diagnose recordings/table --out diagnosis/table --seed 0",
        "version": "0.1.0",
        "seed": 0,
        "noise": {"pose": POSE_SD.tolist(), "force": 0.4, "torque": 0.05, "stated": True},
        "episodes": [episode(index, drag, 0.97 * drag) for index in range(6)],
        "candidates": [
            {
                "effects": ["coulomb_friction"],
                "log_evidence": -8123.4,
                "log_score": -1391.2,
                "probability": 0.978,
            },
            {
                "effects": ["coulomb_friction", "force_bias"],
                "log_evidence": -8127.3,
                "log_score": -1391.9,
                "probability": 0.0198,
            },
            {
                "effects": ["force_bias", "floor_slope"],
                "log_evidence": -8204.0,
                "log_score": None,
                "probability": 1e-9,
            },
            {"effects": ["floor_slope"], "log_evidence": -8893.1, "log_score": -1520.6, "probability": 0.0},
            {"effects": [], "log_evidence": -9555.0, "log_score": -1733.0, "probability": 0.0},
        ],
    }
    return table_diagnosis(), series


def table_diagnosis() -> dict[str, Any]:
    before = {
        "mass": measure(24.31, 0.2, "kg", identifiable=True),
        "wheel_x": measure(-0.42, 0.03, "m", identifiable=True),
        "wheel_mu_x": measure(11.2, 0.9, "N·s/m", identifiable=True),
        "wheel_mu_y": measure(77.77, 1e6, "N·s/m", identifiable=False),
    }
    after = copy.deepcopy(before) | {"mass": measure(21.93, 0.12, "kg", identifiable=True)}
    return {
        "format": "trundle-diagnosis/1",
        "recording": "office table, run 3",
        "verdict": "explained",
        "missing": [
            {
                "effect": "coulomb_friction",
                "probability": 0.98,
                "statement": "Dry friction of 6.0 ± 0.2 N acts near the rear left wheel.",
                "parameters": {"force": measure(6.02, 0.2, "N"), "static_force": measure(6.4, 0.5, "N")},
                "where": {"body_point": {"mean": list(DRAG), "sd": [0.03, 0.02]}},
                "explains": 0.87,
            }
        ],
        "tied": [],
        "mismatch": {
            "windows": [
                {"episode": "episode_05", "start": 0.6, "end": 1.4, "strength": 41.0},
                {"episode": "episode_05", "start": 3.8, "end": 4.6, "strength": 17.2},
                {"episode": "episode_02", "start": 1.2, "end": 3.0, "strength": 22.0},
            ],
            "channels": {"x": 0.1, "y": 0.2, "theta": 0.7},
            "body_point": [-0.45, 0.30],
            "world_region": None,
            "regime": "below 0.03 m/s and at reversals",
        },
        "alternatives": [
            {
                "effect": "second_wheel",
                "probability": 0.02,
                "experiment": "push at (0.6, 0.0) m along \N{MINUS SIGN}y at 0.05 m/s and then at 0.3 m/s",
            }
        ],
        "nominal": {"given": {}, "before": before, "after": after},
        "fit": {"held_out": scores(0.123, 0.008), "training": scores(0.109, 0.0062)},
    }


def tied_sample() -> Sample:
    """A force bias that a slope explains equally well; one parameter is not identifiable."""
    diagnosis, series = table_sample()
    diagnosis["missing"][0] |= {
        "effect": "force_bias",
        "statement": "The sensor reads 0.82 N too little along x once in contact.",
        "parameters": {
            "force_x": measure(-0.82, 0.05, "N"),
            "drift_x": measure(None, None, "N/s", identifiable=False),
        },
        "where": {},
    }
    return diagnosis | {"tied": [["force_bias", "floor_slope"]]}, series


def consistent_sample() -> Sample:
    """Nothing is missing."""
    diagnosis, series = table_sample(drag=0.0)
    mismatch: dict[str, Any] = {
        "windows": [],
        "channels": {"x": 0.3, "y": 0.3, "theta": 0.4},
        "body_point": None,
        "regime": None,
    }
    same = {
        "held_out": {"before": scores(0.008, 0.008)["after"], "after": {}},
        "training": {"before": {}, "after": {}},
    }
    series["candidates"] = [
        {
            "effects": effects,
            "log_evidence": -8123.4 - 4.0 * rank,
            "log_score": -1391.2,
            "probability": probability,
        }
        for rank, (effects, probability) in enumerate(
            [([], 0.97), (["floor_slope"], 0.018), (["force_bias"], 3e-4)]
        )
    ]
    for each in series["episodes"]:
        each["after"] = None
        each["residual"]["after"] = None
    return diagnosis | {
        "verdict": "consistent",
        "missing": [],
        "mismatch": mismatch,
        "alternatives": [],
        "fit": same,
    }, series


def unexplained_sample() -> Sample:
    """An effect that is not in the catalogue; the windows say when it acts, the residual where."""
    diagnosis, series = table_sample()
    poor = {"held_out": scores(0.123, 0.104), "training": scores(0.109, 0.09)}
    return diagnosis | {"verdict": "unexplained", "missing": [], "alternatives": [], "fit": poor}, series


def rail_sample(samples: int = 25_000) -> Sample:
    """A carriage on a rail, sampled at 1 kHz: dry friction and an offset."""
    diagnosis, series = table_sample()
    t = np.arange(samples) * 1e-3
    path = 0.12 * np.sin(0.9 * t) + 0.05 * np.sin(2.3 * t)
    draw = np.random.default_rng(1)

    def pose(x: Array) -> Any:
        return np.column_stack([x, np.zeros((len(x), 2))]).tolist()

    friction = 20.4 * np.sign(np.gradient(path, t)) - 3.2
    noise = draw.normal(size=samples) * 2.0
    residual = {
        "t": t.tolist(),
        "before": pose(-friction + noise),
        "after": pose(0.05 * friction + noise),
        "sd": np.tile([2.0, 1.0, 1.0], (samples, 1)).tolist(),
    }
    series["episodes"] = [
        {
            "name": name,
            "held_out": held,
            "contact": 0.0,
            "t": t.tolist(),
            "observed": pose(path),
            "before": pose(path + 0.0004 * t * np.sin(t)),
            "after": pose(path + 0.00007 * t * np.sin(t)),
            "residual": residual,
            "wrench": None,
        }
        for name, held in (("identification", False), ("pulses", True))
    ]
    series |= {"footprint": [], "support": [], "dof": ["x"]}
    diagnosis["missing"][0]["where"] = {"body_point": None}
    diagnosis["mismatch"]["windows"] = [{"episode": "pulses", "start": 3.1, "end": 4.7, "strength": 12.0}]
    for side in diagnosis["fit"].values():
        for figures in side.values():
            figures |= {
                "position_rmse": figures["position_rmse"] * 0.05,
                "heading_rmse": None,
                "torque_rmse": None,
                "final_heading_error": None,
                "window_heading_rmse": None,
            }
    return diagnosis | {"recording": "emps"}, series


def quasi_static_sample(pushes: int = 40) -> Sample:
    """Slow pushes of a board: wrenches, no mass, no open loop."""
    diagnosis, series = table_sample()
    draw = np.random.default_rng(2)
    series["episodes"] = []
    for index in range(pushes):
        count = 5 if index % 4 else 300
        angle = draw.uniform(0.0, 2.0 * np.pi) + np.linspace(0.0, 1.5, count)
        needed = np.column_stack([2.1 * np.cos(angle), 2.1 * np.sin(angle), 0.12 * np.sin(2.0 * angle)])
        speed = draw.uniform(0.2, 1.6)
        series["episodes"].append(
            {
                "name": f"push_{index:03d}",
                "held_out": index >= pushes // 2,
                "contact": 0.0,
                "t": np.linspace(0.0, 3.0, count).tolist(),
                "observed": np.zeros((count, 3)).tolist(),
                "before": None,
                "after": None,
                "residual": None,
                "wrench": {
                    "t": np.linspace(0.0, 3.0, count).tolist(),
                    "recorded": (needed + draw.normal(size=needed.shape) * [0.1, 0.1, 0.01]).tolist(),
                    "before": (needed * speed).tolist(),
                    "after": needed.tolist(),
                },
            }
        )
    series["quasi_static"] = True
    diagnosis["mismatch"]["windows"] = []
    for side in diagnosis["fit"].values():
        for name, figures in side.items():
            figures |= dict.fromkeys(figures)
            figures |= {"force_rmse": 0.71 if name == "before" else 0.14, "torque_rmse": 0.05}
    diagnosis["nominal"]["after"]["mass"] = measure(3.3333, 99.0, "kg", identifiable=False)
    return diagnosis | {"recording": "hardboard, 10 mm"}, series
