"""Layout of the viewer: the top view and the states on the left, plots and the summary on the right."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from trundle._optional import require
from trundle.viewing.scene import Episode, Scene

__all__ = ["blueprint"]

EYE_DISTANCE = 1.3
"""Distance of the eye from the scene, in sizes of the scene."""


def blueprint(scene: Scene) -> Any:
    """Return the default layout (`rerun.blueprint.Blueprint`) of a scene."""
    rrb = require("rerun.blueprint", "rerun", "Rerun recordings")
    centre, size = bounds(scene.episodes)
    eye = rrb.EyeControls3D(
        position=[*centre, EYE_DISTANCE * size], look_target=[*centre, 0.0], eye_up=[0.0, 1.0, 0.0]
    )
    top = rrb.Spatial3DView(origin="/scene", name="Top view", eye_controls=eye)
    states = rrb.StateTimelineView(origin="/states", name="Episodes, contact and windows")
    panels = {panel.key: panel.title for episode in scene.episodes for panel in episode.panels}
    plots = [
        rrb.TimeSeriesView(origin=f"/plots/{key}", name=title, plot_legend=rrb.PlotLegend(visible=True))
        for key, title in panels.items()
    ]
    summary = rrb.TextDocumentView(origin="/summary", name="Summary")
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(top, states, summary, row_shares=[4, 1, 1]),
            rrb.Vertical(*plots),
            column_shares=[1, 1],
        ),
        rrb.TimePanel(timeline="time", state="collapsed"),
        collapse_panels=True,
    )


def bounds(episodes: Sequence[Episode]) -> tuple[Any, float]:
    """Return the centre (2,) and the size of the motions with their outlines, m."""
    points = np.concatenate([episode.motion.pose[:, :2] for episode in episodes])
    points = points[np.isfinite(points).all(axis=1)]
    low, high = points.min(axis=0), points.max(axis=0)
    reach = max(episode.shape.size for episode in episodes)
    return (low + high) / 2.0, float((high - low).max()) + reach
