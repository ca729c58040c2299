"""Result of each tried model: why it is named or not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report.series import finite

__all__ = ["closest_rejected", "results"]

_BASE = {
    "consistent": "the simulation, refitted: it agrees with the recording",
    "reparameterised": "the simulation, refitted: its laws suffice",
    "explained": "the simulation, refitted: an effect is missing",
    "unexplained": "the simulation, refitted: its residual exceeds what noise explains",
}
"""Result of the model without added effects, by verdict."""


def results(diagnosis: Mapping[str, Any], ranking: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the result of each model in the ranking; the reason of a test takes precedence."""
    verdict = str(diagnosis.get("verdict"))
    named = sorted(str(effect.get("effect")) for effect in diagnosis.get("missing") or ())
    sets = [sorted(map(str, entry.get("effects") or ())) for entry in ranking]
    base = sets.index([]) if [] in sets else len(sets)
    found: list[str] = []
    for index, (entry, effects) in enumerate(zip(ranking, sets, strict=True)):
        if not effects:
            found.append(_BASE.get(verdict, ""))
        elif entry.get("reason"):
            found.append(str(entry["reason"]))
        elif effects == named and "named" not in found:
            found.append("named")
        else:
            found.append(_default(verdict, index, base))
    return found


def _default(verdict: str, index: int, base: int) -> str:
    """Return the reason for not naming a model that no test rejected: its rank."""
    if verdict == "explained":
        return "less probable than the named model"
    if index > base:
        return "less probable than the simulation without it"
    if index == 0:
        return "its residual exceeds what noise explains"
    return "less probable than a closer model, which is rejected"


def closest_rejected(
    diagnosis: Mapping[str, Any], ranking: Sequence[Mapping[str, Any]]
) -> tuple[list[str], str] | None:
    """Return effects and reason of the rejected model with the largest evidence; None if there is none."""
    reasons = results(diagnosis, ranking)
    known = [
        (evidence, index)
        for index, entry in enumerate(ranking)
        if entry.get("effects") and (evidence := finite(entry.get("log_evidence"))) is not None
    ]
    if not known:
        return None
    _, best = max(known, key=lambda pair: (pair[0], -pair[1]))
    return [str(name) for name in ranking[best].get("effects") or ()], reasons[best]
