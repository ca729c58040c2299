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
    """Return the result of each model in the ranking; a test's own reason takes precedence."""
    verdict = str(diagnosis.get("verdict"))
    named = sorted(str(effect.get("effect")) for effect in diagnosis.get("missing") or ())
    base = next((index for index, entry in enumerate(ranking) if not entry.get("effects")), None)
    found = []
    winner: int | None = None
    for index, entry in enumerate(ranking):
        effects = sorted(map(str, entry.get("effects") or ()))
        if effects and effects == named and winner is None and not entry.get("reason"):
            winner = index
            found.append("named")
        elif not effects:
            found.append(_BASE.get(verdict, ""))
        else:
            found.append(str(entry.get("reason") or _default(index, winner, base)))
    return found


def _default(index: int, winner: int | None, base: int | None) -> str:
    """Return the reason for not naming a model that no test rejected: another one ranks higher."""
    if winner is not None:
        return "less probable than the named model"
    if base is not None and index > base:
        return "less probable than the simulation without it"
    return "less probable than a model that was tested and rejected"


def closest_rejected(
    diagnosis: Mapping[str, Any], ranking: Sequence[Mapping[str, Any]]
) -> tuple[list[str], str] | None:
    """Return the effects of the rejected model with the largest evidence, and the reason; None if there is none."""
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
