"""Ranges for domain randomisation from the posterior of a model."""

from __future__ import annotations

from typing import Any

from trundle.mechanism import MechanismModel

__all__ = ["randomisation"]

NORMAL_95 = 1.959964
NOT_NEGATIVE = {
    "armature",
    "damping",
    "mass",
    "effort",
    "static_effort",
    "coefficient",
    "stiffness",
    "gap",
    "delay",
    "time_constant",
    "limit",
    "target_stiffness",
    "target_damping",
    "target_limit",
}
"""Parameters that cannot be negative, whatever the normal approximation gives."""


def randomisation(model: MechanismModel) -> dict[str, Any]:
    """Return the content of `randomisation.toml`.

    Each parameter of the posterior has `mean`, `sd`, `low` and `high` (95 % interval). The covariance
    in `model.toml` holds the correlations.
    """
    table: dict[str, Any] = {"format": "trundle-randomisation/1"}
    if model.posterior is None:
        return table
    deviations = model.posterior.deviations()
    table["parameter"] = []
    for name, mean in zip(model.posterior.names, model.posterior.mean, strict=True):
        sd = deviations[name]
        low, high = mean - NORMAL_95 * sd, mean + NORMAL_95 * sd
        parameter = name.rpartition(".")[2] if "." in name else name.partition(":")[0]
        if parameter in NOT_NEGATIVE:
            low = max(low, 0.0)
        table["parameter"].append({"name": name, "mean": mean, "sd": sd, "low": low, "high": high})
    return table
