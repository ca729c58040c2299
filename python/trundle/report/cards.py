"""Section "Missing effects": one card per effect, without the numbers that the headline states."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from trundle.report import tables, wording
from trundle.report.location import Place, locate_effects
from trundle.report.markup import Html, tag
from trundle.report.section import section
from trundle.report.series import Series, finite
from trundle.report.statement import location_sentences_not_in_statement, parameters_not_in_statement
from trundle.report.unexplained import unexplained_section

__all__ = ["missing_effects"]

_SHARES = (
    ("probability", "probability that the effect is named correctly"),
    ("explains", "of the misfit on held-out data is explained by this effect"),
)
"""Shares in an entry of `missing`: key of diagnosis.json, text."""


def missing_effects(diagnosis: Mapping[str, Any], series: Series) -> Html | None:
    """Return one card per missing effect, or the symptoms if unexplained; None if nothing is missing."""
    if (unexplained := unexplained_section(diagnosis, series)) is not None:
        return unexplained
    effects = diagnosis.get("missing") or ()
    if not effects:
        return None
    cards = [_card(effect, place) for effect, place in zip(effects, locate_effects(effects), strict=True)]
    return section("missing", "Missing effects", tag("div", cards, class_="cards"))


def _card(effect: Mapping[str, Any], place: Place) -> Html:
    name = tag("code", str(effect.get("effect")))
    badge = tag("span", str(place.number), class_="badge")
    statement = effect.get("statement")
    return tag(
        "article",
        tag("h3", badge, f" {wording.capitalise(place.name)} ", name),
        tag("ul", [_share(effect, key, text) for key, text in _SHARES], class_="facts"),
        tables.effect_parameters(parameters_not_in_statement(effect.get("parameters") or {}, statement)),
        [tag("p", sentence) for sentence in location_sentences_not_in_statement(place, statement)],
    )


def _share(effect: Mapping[str, Any], key: str, text: str) -> Html | None:
    share = finite(effect.get(key))
    return None if share is None else tag("li", tag("b", wording.format_percent(share)), f" {text}")
