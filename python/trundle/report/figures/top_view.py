"""A top view with equal scales along both axes, for polygons, paths and points in metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trundle.report.decimate import simplify
from trundle.report.figures.canvas import WIDTH, finite_runs, polyline, round_down_125
from trundle.report.quantity import display_scale
from trundle.report.series import Array
from trundle.report.svg import Child, Markup, tag

__all__ = ["TopView"]

_MARGIN = 14.0
_MIN_HEIGHT, _MAX_HEIGHT = 150.0, 320.0
_SCALE_BAR_HEIGHT = 26.0


@dataclass(frozen=True)
class TopView:
    """A map with `scale` user units per metre, centred at `centre` (2,), m, and `height` user units high."""

    scale: float
    centre: Array
    height: float

    @classmethod
    def around(cls, points: Sequence[Array], height: float | None = None) -> TopView:
        """Return the largest map that shows all points, arrays (n, 2) in m, within a panel of `height`."""
        cloud = np.concatenate([np.empty((0, 2)), *points])
        cloud = cloud[np.isfinite(cloud).all(axis=1)]
        if not len(cloud):
            cloud = np.zeros((1, 2))
        low, high = cloud.min(axis=0), cloud.max(axis=0)
        size = np.maximum(high - low, max(float((high - low).max()), 1e-3) * 1e-3)
        scale = float(
            min((WIDTH - 2.0 * _MARGIN) / size[0], ((height or _MAX_HEIGHT) - 2.0 * _MARGIN) / size[1])
        )
        height = height or float(np.clip(scale * size[1] + 2.0 * _MARGIN, _MIN_HEIGHT, _MAX_HEIGHT))
        return cls(scale, (low + high) / 2.0, height)

    @property
    def total_height(self) -> float:
        """Height of the drawing with the scale bar below the map."""
        return self.height + _SCALE_BAR_HEIGHT

    def to_page(self, points: Array) -> Array:
        """Convert points (n, 2) from metres to user units; y points up in the world and down on the page."""
        centre = np.array([WIDTH / 2.0, self.height / 2.0])
        position: Array = centre + (points - self.centre) * np.array([self.scale, -self.scale])
        return position

    def zoomed(self, about: Array, factor: float) -> TopView:
        """Return the map magnified about a point (2,), m, which keeps its place."""
        return TopView(self.scale * factor, about + (self.centre - about) / factor, self.height)

    def at_origin(self) -> TopView:
        """Return the map with the origin in the top left corner, for groups that are moved as a whole."""
        return TopView(self.scale, np.array([WIDTH, -self.height]) / (2.0 * self.scale), self.height)

    def path(self, points: Array, style: str) -> Markup:
        """Return a line through points (n, 2), simplified to a tolerance of 0.3 user units."""
        parts = [simplify(run, 0.3) for run in finite_runs(self.to_page(points))]
        gap = np.full((1, 2), np.nan)
        return polyline(
            np.concatenate([np.empty((0, 2)), *(row for part in parts for row in (part, gap))]), style
        )

    def outline(self, polygon: Array, style: str) -> Markup | None:
        """Return a closed polygon (n, 2); None if a corner is not finite."""
        if not np.isfinite(polygon).all():
            return None
        corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in self.to_page(polygon))
        return tag("polygon", points=corners, class_=style)

    def with_frame(self, *drawing: Child, tracks: str = "") -> list[Child]:
        """Return the drawing clipped to a frame, with the scale bar below.

        `tracks` names the columns of the data with points that the script marks at the time under the
        pointer, as ``STYLE:X:Y`` separated by ``|``.
        """
        inner = tag(
            "svg",
            *drawing,
            width=WIDTH,
            height=self.height,
            viewBox=f"0 0 {WIDTH:.0f} {self.height:.2f}",
            class_="plot map",
            data_scale=f"{self.scale:.6g} {self.centre[0]:.6g} {self.centre[1]:.6g}",
            **({"data_tracks": tracks} if tracks else {}),
        )
        frame = tag("rect", x=0.5, y=0.5, width=WIDTH - 1.0, height=self.height - 1.0, class_="box")
        return [frame, inner, self._bar()]

    def _bar(self) -> list[Markup]:
        length = round_down_125(0.3 * WIDTH / self.scale)
        y, end = self.height + 11.0, 2.0 + length * self.scale
        ends = [tag("line", x1=x, x2=x, y1=y - 4.0, y2=y + 4.0, class_="axis") for x in (2.0, end)]
        text = display_scale("m", length).text(length, 1)
        return [
            tag("line", x1=2.0, x2=end, y1=y, y2=y, class_="axis"),
            *ends,
            tag("text", text, x=end + 7.0, y=y + 4.0, class_="tick", data_length=length),
        ]
