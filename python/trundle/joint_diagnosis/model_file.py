"""The model file of a diagnosis of joints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from trundle.mechanism import MechanismModel

__all__ = ["build_model"]

TABLE_KEYS = ("joints", "model", "free", "axis", "types", "imposed", "inertia", "gravity", "gravity_torque")
"""Keys of `[mechanism]` that a model file has."""

OF_THE_RECORDING = ("timing",)
"""Kinds of nominal values that describe the sampling of a recording, not the mechanism."""


def build_model(
    table: Mapping[str, Any], fitted: Mapping[str, Any], answer: Mapping[str, Any]
) -> MechanismModel:
    """Return the fitted mechanism as a model file.

    Parameters
    ----------
    table : mapping
        `[mechanism]` of the recording.
    fitted : mapping
        Nominal values and effects.
    answer : mapping
        The content of `diagnosis.json`, for the standard deviations. The covariance is diagonal.
    """
    from trundle.mechanism import JointEffect, MechanismModel, MechanismTable, Posterior

    effects = [
        JointEffect(one["kind"], one.get("joint"), one.get("body"), dict(one["values"]))
        for one in fitted["effects"]
    ]
    means, variances = {}, {}
    for name, estimate in answer["nominal"]["after"].items():
        if _is_of_mechanism(name) and estimate["identifiable"] and estimate["sd"] is not None:
            means[name], variances[name] = estimate["mean"], estimate["sd"] ** 2
    stated = {_name(one["effect"], one["where"]): one["parameters"] for one in answer["missing"]}
    for effect in effects:
        for key, value in effect.parameters.items():
            sd = (stated.get(effect.name, {}).get(key) or {}).get("sd")
            if sd is not None:
                means[f"{effect.name}.{key}"], variances[f"{effect.name}.{key}"] = value, sd**2
    names = list(means)
    covariance = [[variances[name] if name == other else 0.0 for other in names] for name in names]
    return MechanismModel(
        MechanismTable(**{key: table[key] for key in TABLE_KEYS if key in table}),
        {name: value for name, value in fitted["nominal"].items() if _is_of_mechanism(name)},
        effects,
        Posterior(names, [means[name] for name in names], covariance) if names else None,
    )


def _is_of_mechanism(name: str) -> bool:
    return name.split(":")[0] not in OF_THE_RECORDING


def _name(effect: str, where: Mapping[str, str] | None) -> str:
    return ":".join([effect, *(where or {}).values()])
