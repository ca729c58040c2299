"""Figure of a recording: paths from above, and wrench and motion over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from trundle import palette
from trundle.inspection import prepare
from trundle.picture import outlines
from trundle.plots import top_view
from trundle.plots.pushed_path import draw_pushed_path
from trundle.plots.selection import PathLike, choose, is_on_rail, read_recording, short_names
from trundle.plots.style import heading, legend, on_figure, plain
from trundle.plots.time_axes import common_scale, draw_contact, label_lanes
from trundle.recording import Recording
from trundle.report.series import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure
    from matplotlib.gridspec import GridSpec

__all__ = ["recording"]

MAX_EPISODES = 8
"""Maximum number of episodes drawn over time."""
MAX_NAMED_PATHS = 12
"""Maximum number of paths with a name in the top view."""
_X, _Y, _THETA = palette.AFTER, palette.BEFORE, palette.MARK
_WIDTH, _ROW, _MAP = 11.0, 1.15, 4.2
_NOTE = "Wrench on the object, object axes; motion from the first pose. Dotted: start of contact."

Episodes = Mapping[str, Mapping[str, Any]]


def recording(
    recording: Recording | PathLike,
    episode: str | None = None,
    *,
    figure: Figure | SubFigure | None = None,
) -> Figure:
    """Draw a recording: the paths from above, and wrench and motion over time.

    The wrench is tared, in object axes about the object's origin. The motion is relative to the first pose.

    Parameters
    ----------
    recording : Recording or path
    episode : str, optional
        Draws this episode only, with outlines and force arrows along its path. By default all paths, and the
        first eight episodes over time.
    figure : Figure or SubFigure, optional
        Where to draw; by default a new figure.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    TrundleError
        If the episode does not exist, the recording cannot be prepared, or matplotlib is missing.

    Examples
    --------
    >>> import trundle
    >>> recording = trundle.simulate("configs/experiments/demo.toml")
    >>> trundle.plots.recording(recording, "episode_00").savefig("episode.png")  # doctest: +SKIP
    """
    source = read_recording(recording)
    episodes = prepare(source)
    if episode is not None:
        choose(list(episodes), episode, source.name)
        return _draw_episode(source, episode, episodes[episode], figure)
    return _draw_all(source, episodes, figure)


def _draw_all(source: Recording, episodes: Episodes, given: Figure | SubFigure | None) -> Figure:
    shown, rail = list(episodes)[:MAX_EPISODES], is_on_rail(source)
    on, whole = on_figure(given, (_WIDTH, (0.6 if rail else _MAP + 0.6) + _ROW * max(len(shown), 2)))
    columns = 2 if rail else 4
    tops = 0 if rail else 1
    ratios = [] if rail else [_MAP / _ROW]
    grid = on.add_gridspec(tops + len(shown), columns, height_ratios=[*ratios, *(1.0 for _ in shown)])
    if not rail:
        _draw_maps(on, grid, episodes, outlines(source.metadata["object"]))
    _draw_rows(on, grid, tops, {name: episodes[name] for name in shown}, rail)
    held_out = sum(bool(each["held_out"]) for each in episodes.values())
    count = f"{len(episodes)} {'episode' if len(episodes) == 1 else 'episodes'}, {held_out} held out"
    rest = "" if len(shown) == len(episodes) else f"; the first {len(shown)} over time"
    heading(on, source.name, f"{count.capitalize()}{rest}.", _NOTE)
    return whole


def _draw_maps(on: Figure | SubFigure, grid: GridSpec, episodes: Episodes, shape: Sequence[Array]) -> None:
    """Draw the paths of training and of held-out episodes on two maps with the same limits."""
    names, drawn = short_names(list(episodes)), None
    for column, (kind, held_out) in enumerate((("training", False), ("held out", True))):
        axes = on.add_subplot(grid[0, 2 * column : 2 * column + 2], sharex=drawn, sharey=drawn)
        drawn = drawn or axes
        chosen = {names[key]: each for key, each in episodes.items() if bool(each["held_out"]) == held_out}
        _draw_paths(axes, chosen, shape, palette.AFTER if held_out else palette.INK)
        axes.set_title(f"paths of the origin, {kind} ({len(chosen)})", loc="left", fontsize=9)
        top_view.finish(axes, "world")


def _draw_paths(axes: Axes, episodes: Episodes, shape: Sequence[Array], colour: str) -> None:
    """Draw the path of each episode, named if they are few, with the outline where it ends."""
    few = len(episodes) <= MAX_NAMED_PATHS
    for name, each in episodes.items():
        top_view.draw_path(axes, each["pose"], colour, linewidth=1.6 if few else 0.6)
        for end in top_view.first_and_last(each["pose"])[1:]:
            top_view.draw_outlines(axes, shape, end, palette.RECORDED if few else palette.LINE, ":")
            if few:
                place: dict[str, Any] = {
                    "textcoords": "offset points",
                    "fontsize": 8,
                    "color": colour,
                    "weight": "bold",
                }
                axes.annotate(name, end[:2], (4, 3), **place)


def _draw_rows(on: Figure | SubFigure, grid: GridSpec, top: int, episodes: Episodes, rail: bool) -> None:
    """Draw one row of axes for each episode; the axes of a column have the same limits."""
    lanes = _lanes(list(episodes.values()), rail)
    first: list[Axes | None] = [None] * len(lanes)
    for row, (name, each) in enumerate(episodes.items()):
        for column, (title, entries) in enumerate(lanes):
            axes = on.add_subplot(grid[top + row, column], sharex=first[0], sharey=first[column])
            first[column] = first[column] or axes
            draw_contact(axes, each["contact"])
            for t, values, colour, label in entries(each):
                axes.plot(t, values, color=colour, linewidth=0.9, label=label)
            plain(axes)
            axes.tick_params(labelbottom=row == len(episodes) - 1)
            if row == 0:
                axes.set_title(title, loc="left", fontsize=9)
                _name_components(axes)
            if column == 0:
                axes.set_ylabel(f"{name}\n(held out)" if each["held_out"] else name)
            if row == len(episodes) - 1:
                axes.set_xlabel("time (s)")


def _name_components(axes: Axes) -> None:
    """Add a legend of the components if there are two."""
    if len(axes.get_legend_handles_labels()[1]) > 1:
        legend(axes, ncols=2, loc="lower right", bbox_to_anchor=(1.0, 0.95), handlelength=1.2)


def _lanes(episodes: Sequence[Mapping[str, Any]], rail: bool) -> list[tuple[str, Any]]:
    """Return title and curves of each lane; the curves of an episode are (t, values, colour, label)."""
    moved = [_displacement(each) for each in episodes]
    metres = common_scale("m", [each[:, : 1 if rail else 2] for each in moved])
    degrees = common_scale("rad", [each[:, 2] for each in moved])

    def wrench(each: Mapping[str, Any], columns: Sequence[int]) -> list[Any]:
        return [
            (each["wrench_t"], each["on_object"][:, k], (_X, _Y, _THETA)[k], "xy"[k] if k < 2 else "_")
            for k in columns
        ]

    def pose(each: Mapping[str, Any], columns: Sequence[int]) -> list[Any]:
        scale, found = (degrees if columns == [2] else metres), _displacement(each)
        return [
            (each["pose_t"], scale.factor * found[:, k], (_X, _Y, _THETA)[k], "xy"[k] if k < 2 else "_")
            for k in columns
        ]

    plane = [0] if rail else [0, 1]
    lanes: list[tuple[str, Any]] = [("force (N)", lambda each: wrench(each, plane))]
    if not rail:
        lanes.append(("torque (N·m)", lambda each: wrench(each, [2])))
    lanes.append((f"position ({metres.unit})", lambda each: pose(each, plane)))
    if not rail:
        lanes.append((f"heading ({degrees.unit})", lambda each: pose(each, [2])))
    return lanes


def _displacement(each: Mapping[str, Any]) -> Array:
    """Return the poses (n, 3) relative to the first finite one, with a continuous heading."""
    poses = np.array(each["pose"], dtype=np.float64)
    seen = np.isfinite(poses).all(axis=1)
    poses[seen, 2] = np.unwrap(poses[seen, 2])
    moved: Array = poses - poses[seen][0] if seen.any() else poses
    return moved


def _draw_episode(
    source: Recording, name: str, each: Mapping[str, Any], given: Figure | SubFigure | None
) -> Figure:
    rail = is_on_rail(source)
    lanes = _lanes([each], rail)
    on, whole = on_figure(given, (_WIDTH, 1.4 + (1.7 if rail else 1.15) * len(lanes)))
    grid = on.add_gridspec(len(lanes), 1 if rail else 2)
    if not rail:
        draw_pushed_path(on.add_subplot(grid[:, 0]), each, outlines(source.metadata["object"]))
    drawn: list[Axes] = []
    for row, (_, entries) in enumerate(lanes):
        axes = on.add_subplot(grid[row, -1], sharex=drawn[0] if drawn else None)
        draw_contact(axes, each["contact"])
        for t, values, colour, label in entries(each):
            axes.plot(t, values, color=colour, linewidth=1.1, label=label)
        drawn.append(axes)
    label_lanes(drawn, [title for title, _ in lanes])
    for axes in drawn:
        _name_components(axes)
    kind = "held out" if each["held_out"] else "training"
    heading(on, f"{source.name}: {name} ({kind})", _NOTE)
    return whole
