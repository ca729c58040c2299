"""Confidence ellipses of points on a map, and a lens that magnifies small ones."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from trundle.report.figures.canvas import WIDTH
from trundle.report.figures.marks import WITHIN_95
from trundle.report.figures.top_view import TopView
from trundle.report.series import Array
from trundle.report.svg import Child, Markup, tag

__all__ = ["LENS_RADIUS", "LENS_ZOOM", "ellipse", "ellipse_axes", "lens"]

LENS_RADIUS, LENS_ZOOM = 74.0, 10.0
"""Radius of the lens, user units, and its magnification."""


def ellipse_axes(covariance: Array, scale: float, reach: float) -> tuple[float, float, float]:
    """Return the half axes, the longer first, and the clockwise rotation on the page, degrees, of an ellipse.

    Parameters
    ----------
    covariance
        Covariance (2, 2) m² of a normal distribution, of which the ellipse contains 95 %. It may be infinite.
    scale
        Units per metre.
    reach
        Maximum of the half axes, units.
    """
    unknown = (2.0 * reach / scale) ** 2
    values, axes = np.linalg.eigh(np.where(np.isfinite(covariance), covariance, unknown))
    half = np.minimum(WITHIN_95 * np.sqrt(np.maximum(values, 0.0)) * scale, reach)
    return float(half[1]), float(half[0]), -math.degrees(math.atan2(axes[1, 1], axes[0, 1]))


def ellipse(view: TopView, mean: Array, covariance: Array, reach: float, style: str) -> Markup:
    """Return the 95 % ellipse of a point with mean (2,), m, and half axes of at most `reach` user units."""
    long, short, angle = ellipse_axes(covariance, view.scale, reach)
    x, y = view.to_page(mean[None])[0]
    turn = f"translate({x:.2f} {y:.2f}) rotate({angle:.2f})"
    return tag("ellipse", rx=long, ry=short, transform=turn, class_=style)


def lens(identity: str, view: TopView, point: Array, draw: Callable[[TopView], Child]) -> list[Markup]:
    """Return a circle with the magnified surroundings of a point (2,), m, and a line to the point.

    Parameters
    ----------
    identity
        Unique in the page.
    view, point
        The map, and the point that is magnified.
    draw
        Draws the content on a magnified map.
    """
    at = view.to_page(point[None])[0]
    x, y = _lens_centre(at, np.array([WIDTH, view.height]))
    circle = {"cx": x, "cy": y, "r": LENS_RADIUS}
    content = tag(
        "g",
        draw(view.zoomed(point, LENS_ZOOM)),
        transform=f"translate({x - at[0]:.2f} {y - at[1]:.2f})",
    )
    return [
        tag("line", x1=at[0], y1=at[1], x2=x, y2=y, class_="axis"),
        tag("clipPath", tag("circle", **circle), id=f"{identity}-lens"),
        tag("circle", class_="lens", **circle),
        tag("g", content, clip_path=f"url(#{identity}-lens)"),
        tag("circle", class_="rim", **circle),
    ]


def _lens_centre(at: Array, size: Array) -> Array:
    """Return the centre of a lens that does not cover a point (2,), within a panel (2,), user units."""
    toward = size / 2.0 - at
    length = float(np.hypot(*toward))
    way = toward / length if length > 1.0 else np.array([1.0, 0.0])
    centre: Array = np.clip(at + 1.5 * LENS_RADIUS * way, LENS_RADIUS + 4.0, size - LENS_RADIUS - 4.0)
    return centre
