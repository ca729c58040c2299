"""Cards of the missing effects, without the numbers that the headline states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report import tables, wording
from trundle.report.location import Place, locate_effects
from trundle.report.statement import location_sentences_not_in_statement, parameters_not_in_statement
from trundle.report.verdict import tied_with

__all__ = ["missing_effects"]


def missing_effects(diagnosis: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the data of a card for each missing effect."""
    effects = diagnosis.get("missing") or ()
    return [
        _card(effect, place, tied_with(str(effect.get("effect")), diagnosis))
        for effect, place in zip(effects, locate_effects(effects), strict=True)
    ]


def _card(effect: Mapping[str, Any], place: Place, tied: Sequence[str]) -> dict[str, Any]:
    statement = effect.get("statement")
    parameters = parameters_not_in_statement(effect.get("parameters") or {}, statement)
    return {
        "number": place.number,
        "name": wording.capitalise(place.name),
        "kind": str(effect.get("effect")),
        "tied": wording.effect_names(tied, "or"),
        "probability": wording.format_share(effect.get("probability")),
        "explains": wording.explained_by_effect(effect.get("explains")),
        "parameters": tables.effect_parameters(parameters),
        "locations": location_sentences_not_in_statement(place, statement),
    }
