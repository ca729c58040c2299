"""Data of the box "Use this model": ready-made code for `model.toml`, which lies next to the report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from trundle.report import wording
from trundle.report.quantity import join_words
from trundle.report.series import Series

__all__ = ["Snippet", "use"]

_INSTRUMENTS_WITH_MEMORY = frozenset({"sensor_play", "sensor_lag", "drive_lag"})
"""Effects that environments do not simulate."""

_ROLLOUT = """import numpy as np
import trundle

model = trundle.Model.read("model.toml")
t = np.linspace(0.0, 2.0, 201)
wrench = np.tile([20.0, 0.0, 0.0], (201, 1))  # N, N, N·m
poses, twists = model.rollout([0, 0, 0], [0, 0, 0], t, wrench)"""
_FIT = """import trundle

model = trundle.Model.read("model.toml")
for parameter in model.parameters:
    print(parameter)"""
_LAWS = """import trundle
from trundle.export import Laws

laws = Laws(trundle.Model.read("model.toml"))
pose, twist, t = [0.0, 0.0, 0.0], [0.1, 0.0, 0.0], 1.0
missing = laws.wrench(pose, twist, t)  # N, N, N·m, object axes: add it in your simulator"""
_ENVIRONMENT = """import gymnasium
import trundle

options = trundle.objects.task_options("model.toml", "object.toml")
env = gymnasium.make("trundle/PushPose-v0", **options)
observation, info = env.reset(seed=0)"""
_MUJOCO = "trundle export model.toml --mujoco --out mujoco"


@dataclass(frozen=True)
class Snippet:
    """Code with a name; `is_open` if it is shown at first."""

    name: str
    code: str
    is_open: bool = False


def use(diagnosis: Mapping[str, Any], series: Series) -> dict[str, Any]:
    """Return the title, a sentence on the content of the model, and code that works with this model."""
    unexplained = diagnosis.get("verdict") == "unexplained"
    return {
        "title": "Use the refitted model, without the missing effect" if unexplained else "Use this model",
        "content": _content(diagnosis, series),
        "snippets": _snippets(diagnosis, series),
    }


def _content(diagnosis: Mapping[str, Any], series: Series) -> str:
    """Return what `model.toml` contains, and its limits."""
    names = [effect.get("effect") for effect in diagnosis.get("missing") or ()]
    effects = wording.effect_names(names)
    if series.is_black_box:
        added = f"{effects}, to add to your simulator" if names else "the body; no effect is to be added"
        return f"model.toml contains {added}."
    content = {
        "explained": f"model.toml is the simulation with {effects}, fitted.",
        "reparameterised": "model.toml is the simulation with the refitted values.",
        "consistent": "model.toml is the refitted simulation.",
    }.get(str(diagnosis.get("verdict")), "model.toml is the refitted simulation, without the missing effect.")
    if series.discrepancy_inputs:
        inputs = join_words(list(series.discrepancy_inputs))
        content = (
            f"model.toml is the refitted simulation with a learned force that depends on {inputs}. "
            "It predicts near the recorded motions only, and Python alone supports it."
        )
    if series.quasi_static:
        content += " Slow pushes do not determine the mass, without which a motion cannot be simulated."
    return content


def _snippets(diagnosis: Mapping[str, Any], series: Series) -> list[Snippet]:
    if series.is_black_box:
        return [Snippet("Python", _LAWS, True), Snippet("MuJoCo", _MUJOCO)]
    if series.quasi_static:
        return [Snippet("Python", _FIT, True)]
    found = [Snippet("Python", _ROLLOUT, True)]
    if series.discrepancy_inputs or "theta" not in series.dof:
        return found
    effects = {str(effect.get("effect")) for effect in diagnosis.get("missing") or ()}
    if not effects & _INSTRUMENTS_WITH_MEMORY:
        found.append(Snippet("Gymnasium environment", _ENVIRONMENT))
    return [*found, Snippet("MuJoCo", _MUJOCO)]
