"""What is missing, a card an effect, and what would tell it from the rest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from trundle.report import tables
from trundle.report.figures import place
from trundle.report.given import finite
from trundle.report.markup import Html, tag
from trundle.report.quantity import listed, measured, readable
from trundle.report.section import section

__all__ = ["missing"]


def missing(diagnosis: Mapping[str, Any]) -> Html | None:
    """Return what is missing, one card an effect, and what would tell it from the rest."""
    effects = diagnosis.get("missing") or ()
    cards = [*(_card(effect) for effect in effects), _doubts(diagnosis)]
    if not any(cards):
        return None
    return section("What is missing" if effects else "What might be", tag("div", cards, class_="cards"))


def _card(effect: Mapping[str, Any]) -> Html:
    facts = [
        (label, f"{100.0 * value:.0f} %")
        for label, key in (
            ("belongs in the model, given the data", "probability"),
            ("of the held-out misfit is explained by it alone", "explains"),
        )
        if (value := finite(effect.get(key))) is not None
    ]
    return tag(
        "article",
        tag("h3", readable(str(effect.get("effect"))).capitalize()),
        tag("ul", [tag("li", tag("b", value), f" {label}") for label, value in facts], class_="facts"),
        tables.parameters(effect.get("parameters") or {}),
        [tag("p", sentence) for sentence in _where(effect.get("where") or {})],
    )


def _where(where: Mapping[str, Any]) -> list[str]:
    sentences = []
    for key, words in (("body_point", "On the object at"), ("world_point", "In the world at")):
        found = place.point(where, key)
        if found is not None:
            (x, y), (sx, sy) = found
            sentences.append(f"{words} ({measured(x, sx)}, {measured(y, sy)}) m.")
        elif key in where:
            sentences.append(f"{words} a place that the data do not hold.")
    if where.get("world_region"):
        sentences.append("On the floor in the region that the maps below show hatched.")
    event = where.get("event")
    if isinstance(event, Mapping):
        time = event.get("time") or {}
        sentences.append(f"In {event.get('episode')} at {measured(time.get('mean'), time.get('sd'))} s.")
    return sentences


def _doubts(diagnosis: Mapping[str, Any]) -> Html | None:
    """Return what the data cannot tell apart, and the experiment that would."""
    groups = [
        listed([readable(str(name)) for name in group], "or")
        for group in diagnosis.get("tied") or ()
        if len(group) > 1
    ]
    others = diagnosis.get("alternatives") or ()
    if not groups and not others:
        return None
    tied = [tag("p", tag("b", group), ": this recording cannot tell.") for group in groups]
    title = tag("h3", "What it might be instead, and what would tell")
    return tag("article", title, tied, [_alternative(entry) for entry in others], class_="doubt")


def _alternative(entry: Mapping[str, Any]) -> Html:
    probability = finite(entry.get("probability"))
    share = "" if probability is None else f" ({100.0 * probability:.0f} %)"
    experiment = str(entry.get("experiment") or "no experiment is known that would tell")
    return tag(
        "p", tag("b", readable(str(entry.get("effect"))).capitalize()), f"{share}. To tell: ", experiment
    )
