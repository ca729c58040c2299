"""A picture of a recording: top view of the paths, and poses and wrenches over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from trundle._optional import require
from trundle.atomic import atomic_file
from trundle.inspection import prepare
from trundle.recording import Recording, TrundleError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw", "figure"]

SUFFIXES = (".png", ".svg", ".pdf")
OUTLINES_PER_EPISODE = 6
"""Footprints drawn along the path of each episode."""
MAX_EPISODE_ROWS = 8
"""Maximum number of episodes drawn over time."""

Floats = NDArray[np.float64]


def draw(recording: Recording, path: Path) -> None:
    """Draw a recording and save it.

    Parameters
    ----------
    recording : Recording
        What to draw.
    path : Path
        Output file with the suffix .png, .svg or .pdf.

    Raises
    ------
    TrundleError
        If the suffix is another one, or the recording cannot be prepared.
    """
    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        raise TrundleError(f"{path}: unknown suffix; use one of {', '.join(SUFFIXES)}")
    drawn = figure(recording)
    with atomic_file(path) as part:
        drawn.savefig(part, format=kind[1:], metadata={"Date": None} if kind == ".svg" else None)


def figure(recording: Recording) -> Figure:
    """Return the picture as a matplotlib figure.

    Parameters
    ----------
    recording : Recording
        What to draw.

    Returns
    -------
    matplotlib.figure.Figure
        The top view, then one row per episode: wrench and pose over time.
    """
    matplotlib = require("matplotlib.figure", "plots", "plots")
    episodes = prepare(recording)
    shown = list(episodes)[:MAX_EPISODE_ROWS]
    drawn: Figure = matplotlib.Figure(figsize=(11, 4.5 + 1.6 * len(shown)), layout="constrained")
    grid = drawn.add_gridspec(1 + len(shown), 2, height_ratios=[3.0, *(1.0 for _ in shown)])
    draw_top_view(drawn.add_subplot(grid[0, :]), episodes, outlines(recording.metadata["object"]))
    drawn.suptitle(title(recording.name, len(shown), len(episodes)))
    for row, name in enumerate(shown, start=1):
        draw_wrench(drawn.add_subplot(grid[row, 0]), name, episodes[name])
        draw_pose(drawn.add_subplot(grid[row, 1]), episodes[name])
    return drawn


def title(name: str, shown: int, total: int) -> str:
    """Return the title of the picture, with the number of episodes that have a row."""
    return name if shown == total else f"{name}: the first {shown} of {total} episodes over time"


def outlines(described: Mapping[str, Any]) -> list[Floats]:
    """Return the shapes of the object as closed outlines (n, 2), m, object frame; empty on a rail."""
    fixtures = described.get("fixture") or [{"polygon": described.get("footprint") or []}]
    return [closed_outline(fixture) for fixture in fixtures if fixture.get("polygon") or fixture.get("disc")]


def closed_outline(fixture: Mapping[str, Any]) -> Floats:
    """Return one polygon or disc as a closed outline (n, 2), m, object frame."""
    if fixture.get("polygon"):
        return np.asarray([*fixture["polygon"], fixture["polygon"][0]], dtype=float)
    x, y, radius = fixture["disc"]
    angle = np.linspace(0.0, 2.0 * np.pi, 49)
    return np.column_stack([x + radius * np.cos(angle), y + radius * np.sin(angle)])


def draw_top_view(axes: Axes, episodes: Mapping[str, Mapping[str, Any]], shape: Sequence[Floats]) -> None:
    """Draw the path of the object's origin in each episode, with outlines along it."""
    for index, episode in enumerate(episodes.values()):
        colour, poses = f"C{index % 10}", episode["pose"]
        axes.plot(poses[:, 0], poses[:, 1], color=colour, linestyle="--" if episode["held_out"] else "-")
        for at in np.unique(np.linspace(0, len(poses) - 1, OUTLINES_PER_EPISODE).astype(int)):
            for outline in shape:
                placed = place_outline(outline, poses[at])
                axes.plot(placed[:, 0], placed[:, 1], color=colour, linewidth=0.7, alpha=0.5)
    axes.set(xlabel="x (m)", ylabel="y (m)", title="from above (held out: dashed)")
    axes.set_aspect("equal", adjustable="datalim")


def place_outline(outline: Floats, at: Floats) -> Floats:
    """Return an outline (n, 2) of the object frame in the world, for the object at `at` (x, y, theta)."""
    cos, sin = np.cos(at[2]), np.sin(at[2])
    placed: Floats = outline @ np.array([[cos, sin], [-sin, cos]]) + at[:2]
    return placed


def draw_wrench(axes: Axes, name: str, episode: Mapping[str, Any]) -> None:
    """Draw the wrench on the object over time, and the start of contact."""
    for column, label in enumerate(("force x (N)", "force y (N)", "torque (N m)")):
        axes.plot(episode["wrench_t"], episode["on_object"][:, column], linewidth=0.8, label=label)
    axes.axvline(episode["contact"], color="grey", linewidth=0.8, linestyle=":")
    axes.set(xlabel="t (s)", ylabel=name + (" (held out)" if episode["held_out"] else ""))
    axes.legend(loc="upper right", fontsize="x-small")


def draw_pose(axes: Axes, episode: Mapping[str, Any]) -> None:
    """Draw the pose relative to the first one over time."""
    displacement = episode["pose"] - episode["pose"][0]
    for column, label in enumerate(("x (m)", "y (m)", "heading (rad)")):
        axes.plot(
            episode["pose_t"], displacement[:, column], linewidth=0.8, marker=".", markersize=1.5, label=label
        )
    axes.set(xlabel="t (s)", ylabel="from the start")
    axes.legend(loc="upper left", fontsize="x-small")
