"""What is missing, a card an effect: how sure, how large, where and when."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from trundle.report import tables, words
from trundle.report.given import Series, finite
from trundle.report.markup import Html, tag
from trundle.report.section import section
from trundle.report.verdict import judged
from trundle.report.where import Place, places

__all__ = ["missing"]

_FACTS = (
    ("probability", "likely to belong in the model, given the data"),
    ("explains", "of the misfit on held-out data is this effect's"),
)


def missing(diagnosis: Mapping[str, Any], series: Series) -> Html | None:
    """Return what is missing, one card an effect, and what it brings; None where nothing has a name."""
    effects = diagnosis.get("missing") or ()
    if not effects:
        return None
    cards = [_card(effect, place) for effect, place in zip(effects, places(effects), strict=True)]
    return section("missing", "What is missing", tag("div", cards, _gain(diagnosis, series), class_="cards"))


def _card(effect: Mapping[str, Any], place: Place) -> Html:
    name = tag("code", str(effect.get("effect")))
    badge = tag("span", str(place.number), class_="badge")
    return tag(
        "article",
        tag("h3", badge, f" {words.capitalised(place.name)} ", name),
        tag("ul", [_fact(effect, key, text) for key, text in _FACTS], class_="facts"),
        tables.parameters(effect.get("parameters") or {}),
        [tag("p", sentence) for sentence in place.sentences()],
    )


def _fact(effect: Mapping[str, Any], key: str, text: str) -> Html | None:
    share = finite(effect.get(key))
    return None if share is None else tag("li", tag("b", words.percent(share)), f" {text}")


def _gain(diagnosis: Mapping[str, Any], series: Series) -> Html | None:
    """Return the errors that matter most, before and after, and by what factor they fall."""
    kind, scores = judged(diagnosis)
    table = tables.gain(scores, series.quasi_static)
    if table is None:
        return None
    title = f"What it brings on {kind} {series.pushes}"
    return tag("article", tag("h3", title), table, class_="doubt")
