"""What is missing, a card an effect: how sure, and what the sentence below the headline does not say."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from trundle.report import tables, words
from trundle.report.given import Series, finite
from trundle.report.markup import Html, tag
from trundle.report.section import section
from trundle.report.stated import places_left, unstated
from trundle.report.unexplained import symptoms
from trundle.report.where import Place, places

__all__ = ["missing"]

_FACTS = (
    ("probability", "probability that this name is right"),
    ("explains", "of the misfit on held-out data is this effect's"),
)


def missing(diagnosis: Mapping[str, Any], series: Series) -> Html | None:
    """Return what is missing, one card an effect; None where nothing has a name."""
    if (unnamed := symptoms(diagnosis, series)) is not None:
        return unnamed
    effects = diagnosis.get("missing") or ()
    if not effects:
        return None
    cards = [_card(effect, place) for effect, place in zip(effects, places(effects), strict=True)]
    return section("missing", "What is missing", tag("div", cards, class_="cards"))


def _card(effect: Mapping[str, Any], place: Place) -> Html:
    name = tag("code", str(effect.get("effect")))
    badge = tag("span", str(place.number), class_="badge")
    statement = effect.get("statement")
    return tag(
        "article",
        tag("h3", badge, f" {words.capitalised(place.name)} ", name),
        tag("ul", [_fact(effect, key, text) for key, text in _FACTS], class_="facts"),
        tables.parameters(unstated(effect.get("parameters") or {}, statement)),
        [tag("p", sentence) for sentence in places_left(place, statement)],
    )


def _fact(effect: Mapping[str, Any], key: str, text: str) -> Html | None:
    share = finite(effect.get(key))
    return None if share is None else tag("li", tag("b", words.percent(share)), f" {text}")
