"""The object from above, with the places that the diagnosis names on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from trundle.report.figures import marks, wheels
from trundle.report.figures.canvas import figure, label
from trundle.report.figures.plan import Plan
from trundle.report.given import Array, Series
from trundle.report.markup import Child, Html, tag
from trundle.report.quantity import fixed
from trundle.report.where import Place, Spot, pair, places

__all__ = ["body", "draw", "hinted"]


def draw(diagnosis: Mapping[str, Any], series: Series) -> Html | None:
    """Footprint, support and places; None where no footprint is given (a rail)."""
    if not series.footprint:
        return None
    missing = places(diagnosis.get("missing") or ())
    named = [(place, place.body) for place in missing if place.body is not None]
    hint = hinted(diagnosis)
    fitted = wheels.fitted(diagnosis.get("nominal") or {})
    corners = np.concatenate(series.footprint)
    plan = Plan.around(
        [
            corners,
            *series.feet,
            *_near([*(spot.mean for _, spot in named), *(w.place for w in fitted)], hint, corners),
        ]
    )
    drawing = plan.framed(
        body(plan, series),
        [wheels.draw(plan, wheel) for wheel in fitted],
        [marks.cross(plan, spot) for _, spot in named],
        marks.numbers(plan, [_numbered(plan, place, spot) for place, spot in named]),
        None if hint is None else marks.diamond(plan, hint),
    )
    sentences = [f"{place.number}: {place.name} at {spot}" for place, spot in named]
    if hint is not None:
        sentences.append(f"the missing wrench acts near {_at(hint)}")
    described = "; ".join(sentences) or "the diagnosis names no place on it"
    return figure(
        "object",
        "The object from above",
        f"Footprint in the object frame; {described}.",
        plan.total,
        drawing,
        _caption(named, hint, len(fitted), bool(series.feet)),
    )


def hinted(diagnosis: Mapping[str, Any]) -> Array | None:
    """Return where on the object something acts that has no name, (2,) m."""
    if diagnosis.get("verdict") != "unexplained":
        return None
    return pair((diagnosis.get("mismatch") or {}).get("body_point"))


def body(plan: Plan, series: Series) -> list[Child]:
    """Return the object in its own frame: outline, axes, and where it stands."""
    return [
        [plan.outline(polygon, "footprint") for polygon in series.footprint],
        _axes(plan, np.concatenate(series.footprint)),
        [_support(plan, foot) for foot in series.support],
    ]


def _numbered(plan: Plan, place: Place, spot: Spot) -> tuple[int, Array, float]:
    return place.number, spot.mean, float(marks.WITHIN_95 * spot.sd[0] * plan.scale)


def _near(spots: Sequence[Array], hint: Array | None, corners: Array) -> list[Array]:
    """Return the places to show, unless so far off that the object would shrink to a dot."""
    reach = 2.0 * float(np.ptp(corners, axis=0).max())
    found = [*spots] + ([] if hint is None else [hint])
    return [place[None] for place in found if np.abs(place - corners.mean(axis=0)).max() < reach]


def _axes(plan: Plan, corners: Array) -> list[Html]:
    """Return the object frame: where x and y point."""
    length = 0.22 * float(np.ptp(corners, axis=0).min())
    tips = np.array([[0.0, 0.0], [length, 0.0], [0.0, length]])
    origin, x, y = plan.at(tips)
    arms = [marks.arrow(origin, tip, "axis", head=6.0) for tip in (x, y)]
    names = [label("x", x[0] + 5.0, x[1] + 4.0, "tick"), label("y", y[0], y[1] - 6.0, "tick", "middle")]
    return [*arms, *names]


def _support(plan: Plan, foot: Array) -> Html | None:
    if not np.isfinite(foot).all():
        return None
    x, y = plan.at(foot[None])[0]
    return tag("circle", cx=x, cy=y, r=5.0, class_="support")


def _at(place: Array) -> str:
    return f"({fixed(place[0], 2)}, {fixed(place[1], 2)})\N{NO-BREAK SPACE}m"


def _caption(named: Sequence[tuple[Place, Spot]], hint: Array | None, fitted: int, feet: bool) -> list[Child]:
    lines: list[Child] = [
        [
            tag("b", f"{place.number} "),
            place.name,
            ", with its 95\N{NO-BREAK SPACE}% ellipse" if spot.sd.all() else None,
            ". ",
        ]
        for place, spot in named
    ]
    if hint is not None:
        lines.append("◇ where the missing wrench acts. ")
    if not named and hint is None:
        lines.append("The diagnosis names no place on the object. ")
    if fitted:
        lines.append(f"▬ the fitted {'wheel' if fitted == 1 else 'wheels'}. ")
    return [lines, "From above, object frame", "; circles: where it stands on the floor." if feet else "."]
