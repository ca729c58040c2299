"""The object from above, with the places that the diagnosis names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from trundle.report.figures.canvas import figure, label
from trundle.report.figures.plan import Plan
from trundle.report.given import Array, Series, finite
from trundle.report.markup import Child, Html, tag
from trundle.report.quantity import fixed, measured, readable

__all__ = ["draw", "point"]

_WITHIN_95 = 2.4477
"""Radius in standard deviations of the ellipse that holds a planar normal with probability 0.95."""


@dataclass(frozen=True)
class _Spot:
    """A place on the object: mean (2,) and standard deviation (2,) m (zero where not stated)."""

    name: str
    mean: Array
    sd: Array
    words: str


def draw(diagnosis: Mapping[str, Any], series: Series) -> Html | None:
    """Footprint, support and places; None where no footprint is given (a rail)."""
    if not series.footprint:
        return None
    spots = _spots(diagnosis.get("missing") or ())
    unexplained = diagnosis.get("verdict") == "unexplained"
    hint = _pair((diagnosis.get("mismatch") or {}).get("body_point")) if unexplained else None
    corners = np.concatenate(series.footprint)
    plan = Plan.around(
        [corners, *([series.support] if len(series.support) else []), *_near(spots, hint, corners)]
    )
    drawing = plan.framed(
        [plan.outline(polygon, "footprint") for polygon in series.footprint],
        _axes(plan, corners),
        [_support(plan, foot) for foot in series.support],
        [_mark(plan, index, spot) for index, spot in enumerate(spots, 1)],
        None if hint is None else _hint(plan, hint),
    )
    sentences = [f"{index}: {spot.name} at {spot.words}" for index, spot in enumerate(spots, 1)]
    if hint is not None:
        sentences.append(f"the missing wrench acts near ({fixed(hint[0], 2)}, {fixed(hint[1], 2)}) m")
    described = "; ".join(sentences) or "the diagnosis names no place on it"
    return figure(
        "object",
        "The object from above",
        f"Footprint in the object frame; {described}.",
        plan.total,
        drawing,
        _caption(spots, hint, bool(len(series.support))),
    )


def point(where: Mapping[str, Any] | None, key: str) -> tuple[Array, Array] | None:
    """Mean and standard deviation, (2,) m each, of a place in `where`; None where the data do not hold it."""
    given = where.get(key) if where else None
    if not isinstance(given, Mapping) or (mean := _pair(given.get("mean"))) is None:
        return None
    sd = _pair(given.get("sd"))
    return mean, np.zeros(2) if sd is None else sd


def _pair(given: object) -> Array | None:
    if not isinstance(given, Sequence | np.ndarray) or len(given) != 2:
        return None
    numbers = [finite(value) for value in given]
    return None if None in numbers else np.array(numbers, dtype=np.float64)


def _spots(missing: Sequence[Mapping[str, Any]]) -> list[_Spot]:
    spots = []
    for effect in missing:
        found = point(effect.get("where"), "body_point")
        if found is not None:
            mean, sd = found
            words = f"({measured(mean[0], sd[0])}, {measured(mean[1], sd[1])}) m"
            spots.append(_Spot(readable(str(effect.get("effect"))), mean, sd, words))
    return spots


def _near(spots: Sequence[_Spot], hint: Array | None, corners: Array) -> list[Array]:
    """Return the places to show, unless so far off that the object would shrink to a dot."""
    reach = 2.0 * float(np.ptp(corners, axis=0).max())
    places = [spot.mean for spot in spots] + ([] if hint is None else [hint])
    return [place[None] for place in places if np.abs(place - corners.mean(axis=0)).max() < reach]


def _axes(plan: Plan, corners: Array) -> list[Html]:
    """Return the object frame: where x and y point."""
    length = 0.22 * float(np.ptp(corners, axis=0).min())
    tips = np.array([[0.0, 0.0], [length, 0.0], [0.0, length]])
    origin, x, y = plan.at(tips)
    arms = [tag("line", x1=origin[0], y1=origin[1], x2=tip[0], y2=tip[1], class_="axis") for tip in (x, y)]
    names = [label("x", x[0] + 5.0, x[1] + 4.0, "tick"), label("y", y[0] - 3.0, y[1] - 6.0, "tick")]
    return [*arms, *names]


def _support(plan: Plan, foot: Array) -> Html | None:
    if not np.isfinite(foot).all():
        return None
    x, y = plan.at(foot[None])[0]
    return tag("circle", cx=x, cy=y, r=5.0, class_="support")


def _mark(plan: Plan, index: int, spot: _Spot) -> Child:
    x, y = plan.at(spot.mean[None])[0]
    rx, ry = _WITHIN_95 * spot.sd * plan.scale
    aside = (max(rx, 9.0) + 9.0) * (-1.0 if x > 300.0 else 1.0)
    return [
        tag("ellipse", cx=x, cy=y, rx=rx, ry=ry, class_="likely"),
        tag("line", x1=x - 9.0, x2=x + 9.0, y1=y, y2=y, class_="mark"),
        tag("line", x1=x, x2=x, y1=y - 9.0, y2=y + 9.0, class_="mark"),
        label(str(index), x + aside, y + 6.0, "number", "middle"),
    ]


def _hint(plan: Plan, place: Array) -> Html:
    x, y = plan.at(place[None])[0]
    return tag("path", d=f"M{x:.1f} {y - 10:.1f}l10 10l-10 10l-10 -10z", class_="hint")


def _caption(spots: Sequence[_Spot], hint: Array | None, feet: bool) -> list[Child]:
    lines: list[Child] = [
        [
            tag("b", f"{index} "),
            f"{spot.name}: {spot.words}",
            ", with its 95 % ellipse" if spot.sd.all() else None,
            ". ",
        ]
        for index, spot in enumerate(spots, 1)
    ]
    if hint is not None:
        lines.append(f"◇ the missing wrench acts near ({fixed(hint[0], 2)}, {fixed(hint[1], 2)}) m. ")
    if not spots and hint is None:
        lines.append("The diagnosis names no place on the object. ")
    return [lines, "From above, object frame", "; circles: where it stands on the floor." if feet else "."]
