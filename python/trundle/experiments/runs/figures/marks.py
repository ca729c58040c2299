"""Marks of a wheel in user units: estimate, uncertainty, and true wheel."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from trundle.experiments.runs.history import Effect
from trundle.report.markup import Html, tag
from trundle.report.series import Array

__all__ = ["EllipseAxes", "box", "cross", "effect_marks", "ellipse", "ellipse_axes"]

WITHIN_95 = 2.4477
"""Radius in standard deviations of the 95 % ellipse of a planar normal distribution."""
CROSS_ARM = 9.0

EllipseAxes = tuple[float, float, float]
"""Half axes, the longer first, and the rotation, degrees, clockwise on the page."""


def ellipse_axes(spread: Array | None, scale: float, reach: float) -> EllipseAxes | None:
    """Return the ellipse of a covariance (2, 2) m², limited to `reach`; None without a covariance."""
    if spread is None:
        return None
    wide = (2.0 * reach / scale) ** 2
    values, ways = np.linalg.eigh(np.where(np.isfinite(spread), spread, wide))
    half = np.minimum(WITHIN_95 * np.sqrt(np.maximum(values, 0.0)) * scale, reach)
    return float(half[1]), float(half[0]), -math.degrees(math.atan2(ways[1, 1], ways[0, 1]))


def ellipse(at: Array, shape: EllipseAxes) -> Html:
    """Return the 95 % ellipse."""
    turn = f"translate({at[0]:.2f} {at[1]:.2f}) rotate({shape[2]:.2f})"
    return tag("ellipse", rx=shape[0], ry=shape[1], transform=turn, class_="held")


def cross(at: Array) -> Html:
    """Return the mark of an estimated position."""
    x, y, arm = at[0], at[1], CROSS_ARM
    d = f"M{x - arm:.1f} {y:.1f}h{2 * arm:.0f}M{x:.1f} {y - arm:.1f}v{2 * arm:.0f}"
    return tag("path", d=d, class_="spot")


def effect_marks(
    found: Sequence[Effect], hidden: Sequence[Effect], at: Callable[[Array], Array]
) -> list[Html]:
    """Return marks of estimated and true positions of other effects; `at` maps (2,) m to user units."""
    rings = [tag("circle", cx=x, cy=y, r=8.0, class_="mark hollow") for x, y in effect_points(hidden, at)]
    d = "".join(
        f"M{x - 5:.1f} {y - 5:.1f}l10 10M{x - 5:.1f} {y + 5:.1f}l10 -10" for x, y in effect_points(found, at)
    )
    return [*rings, tag("path", d=d, class_="mark")] if d else rings


def effect_points(effects: Sequence[Effect], at: Callable[[Array], Array]) -> list[Array]:
    """Return the positions of effects, in user units."""
    return [at(each.at) for each in effects if each.at is not None]


def box(at: Array, angle: float) -> Html:
    """Return the true wheel, with its long side along the direction of least drag; `angle` rad, x to y."""
    turn = f"translate({at[0]:.2f} {at[1]:.2f}) rotate({-math.degrees(angle):.2f})"
    return tag("rect", x=-11.0, y=-5.0, width=22.0, height=10.0, rx=4.0, transform=turn, class_="truth")
