"""Figures of residuals over time: of the pose in open loop, or of the wrench."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from trundle import palette
from trundle.diagnosis import Diagnosis
from trundle.fitting import Fit
from trundle.inspection import inspect
from trundle.model import Model
from trundle.plots.motion import SIDES
from trundle.plots.selection import PathLike, choose, open_loop, quasi_static_note, read_recording
from trundle.plots.style import heading, legend, on_figure, plain
from trundle.plots.time_axes import common_scale, draw_band, draw_marks
from trundle.recording import Recording, TrundleError
from trundle.report.figures.motion import events_in
from trundle.report.figures.residual import CHANNELS, select_episodes, windows_in
from trundle.report.location import locate_effects
from trundle.report.quantity import Scale
from trundle.report.series import Array, Episode, Residual, Series, held_out_first
from trundle.report.verdict import is_single

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

__all__ = ["residual"]

MAX_EPISODES = 8
"""Maximum number of episodes that are drawn by default."""
_WIDTH, _ROW = 11.0, 1.3
_AXES = ("x", "y", "heading")


def residual(
    source: Fit | Model | Diagnosis | PathLike,
    recording: Recording | PathLike | None = None,
    episodes: str | Sequence[str] | None = None,
    *,
    figure: Figure | SubFigure | None = None,
) -> Figure:
    """Draw what a model does not explain, over time and by episode.

    For a fit or a model this is the residual of the pose: recorded minus simulated in open loop, world axes.
    For a diagnosis it is the residual wrench on the object, object axes, without and with the missing
    effects.

    Parameters
    ----------
    source : Fit, Model, Diagnosis or path
        A path is that of a model file. A model must contain a value for every parameter.
    recording : Recording or path, optional
        Needed for a fit or a model, and not used for a diagnosis, which contains its residuals.
    episodes : str or sequence of str, optional
        Names of episodes. By default up to eight: held-out episodes first for a model, the largest residuals
        first for a diagnosis.
    figure : Figure or SubFigure, optional
        Where to draw; by default a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        One row per episode and one column per axis. The band shows two standard deviations of the noise.

    Raises
    ------
    TrundleError
        If an episode does not exist, a model has no recording, a diagnosis has no residual wrenches, a
        parameter has no value, or matplotlib is missing.

    Examples
    --------
    >>> import trundle
    >>> recording = trundle.simulate("configs/experiments/demo.toml")
    >>> fitted = trundle.fit(recording)  # doctest: +SKIP
    >>> trundle.plots.residual(fitted, recording)  # doctest: +SKIP
    """
    if isinstance(source, Diagnosis):
        return _draw_wrenches(source, episodes, figure)
    if recording is None:
        raise TrundleError("residual: the recording is missing; call residual(model, recording)")
    model = source.model if isinstance(source, Fit) else source
    parsed = model if isinstance(model, Model) else Model.read(model)
    note = quasi_static_note(source.summary) if isinstance(source, Fit) else ""
    return _draw_poses(parsed, read_recording(recording), episodes, figure, note)


def _draw_poses(
    model: Model,
    recording: Recording,
    wanted: str | Sequence[str] | None,
    figure: Figure | SubFigure | None,
    note: str,
) -> Figure:
    series = open_loop(recording, model)
    ordered = held_out_first(series.episodes)
    drawn = _limited(ordered, wanted, recording.name)
    gaps = [_pose_gap(episode) for episode in drawn]
    scales = _pose_scales(gaps, series)
    noise = np.asarray(inspect(recording).noise.pose, dtype=np.float64)
    titles = [f"{_AXES[k]} ({scales[k].unit})" for k in series.channels]
    on, whole, grid = _rows(drawn, titles, figure)
    for row, (episode, gap) in enumerate(zip(drawn, gaps, strict=True)):
        for column, k in enumerate(series.channels):
            axes, factor = grid[row][column], scales[k].factor
            draw_band(axes, episode.t, np.full(len(episode.t), factor * noise[k]))
            axes.plot(episode.t, factor * gap[:, k], label="recorded minus simulated", **SIDES["after"])
    _finish(on, grid)
    shown = _shown(drawn, ordered)
    heading(on, f"{recording.name}: residual of the pose in open loop", "World axes.", shown, note)
    return whole


def _draw_wrenches(
    diagnosis: Diagnosis, wanted: str | Sequence[str] | None, figure: Figure | SubFigure | None
) -> Figure:
    answer = diagnosis.answer
    series = Series.parse(diagnosis.series, single=is_single(answer, diagnosis.series.get("unnamed")))
    windows = (answer.get("mismatch") or {}).get("windows") or ()
    ordered = select_episodes(series, windows, tuple(SIDES))
    name = str(answer.get("recording"))
    if not ordered:
        raise TrundleError(f"{name}: this diagnosis has no residual wrenches; it compares required wrenches")
    drawn = _limited(ordered, wanted, name)
    titles = [f"{CHANNELS[k][0]} ({CHANNELS[k][1]})" for k in series.channels]
    on, whole, grid = _rows(drawn, titles, figure)
    named = locate_effects(answer.get("missing") or ())
    for row, episode in enumerate(drawn):
        for column, k in enumerate(series.channels):
            axes = grid[row][column]
            if episode.residual is not None:
                _draw_channel(axes, episode.residual, k)
            draw_marks(axes, windows_in(episode, windows), events_in(episode, named))
    _finish(on, grid)
    marked = "Shaded: windows that exceed the noise." if windows else ""
    heading(on, f"{name}: residual wrench", "On the object, object axes.", marked, _shown(drawn, ordered))
    return whole


def _draw_channel(axes: Axes, found: Residual, channel: int) -> None:
    """Draw one component of the residual wrench, without and with the missing effects, and its noise."""
    sd = found.sd if found.sd is not None else found.sd_after
    if sd is not None:
        draw_band(axes, found.t, sd[:, channel])
    sides = [(side, curve) for side in SIDES if (curve := getattr(found, side)) is not None]
    for side, curve in sides:
        style: dict[str, Any] = {"color": SIDES[side]["color"], "linewidth": 0.9}
        label = side if len(sides) > 1 else "residual"
        axes.plot(found.t, curve[:, channel], label=label, **style)


def _limited(ordered: Sequence[Episode], wanted: str | Sequence[str] | None, of: str) -> list[Episode]:
    """Return the wanted episodes in their order; for None the first `MAX_EPISODES`."""
    names = choose([each.name for each in ordered], wanted, of)
    by_name = {each.name: each for each in ordered}
    return [by_name[name] for name in (names[:MAX_EPISODES] if wanted is None else names)]


def _shown(drawn: Sequence[Episode], ordered: Sequence[Episode]) -> str:
    return "" if len(drawn) == len(ordered) else f"{len(drawn)} of {len(ordered)} episodes are shown."


def _pose_gap(episode: Episode) -> Array:
    """Return recorded minus simulated poses (n, 3), with angles in (-pi, pi]; NaN without a simulation."""
    if episode.after is None:
        return np.full_like(episode.observed, np.nan)
    gap: Array = episode.observed - episode.after
    gap[:, 2] = np.arctan2(np.sin(gap[:, 2]), np.cos(gap[:, 2]))
    return gap


def _pose_scales(gaps: Sequence[Array], series: Series) -> list[Scale]:
    """Return the display units of x, y and heading; x and y have the same."""
    plane = [k for k in series.channels if k < 2]
    metres = common_scale("m", [gap[:, plane] for gap in gaps])
    return [metres, metres, common_scale("rad", [gap[:, 2] for gap in gaps])]


def _rows(
    drawn: Sequence[Episode], titles: Sequence[str], figure: Figure | SubFigure | None
) -> tuple[Any, Figure, list[list[Axes]]]:
    """Return the figure to draw on, the whole figure, and axes by row and column."""
    on, whole = on_figure(figure, (_WIDTH, 1.2 + _ROW * max(2, len(drawn))))
    grid = on.subplots(len(drawn), len(titles), squeeze=False, sharex=True, sharey="col")
    for row, episode in enumerate(drawn):
        for column, title in enumerate(titles):
            axes = grid[row, column]
            plain(axes)
            axes.axhline(0.0, color=palette.MUTED, linewidth=0.7)
            if row == 0:
                axes.set_title(title, loc="left", fontsize=9)
            if row == len(drawn) - 1:
                axes.set_xlabel("time (s)")
        grid[row, 0].set_ylabel(f"{episode.name}\n(held out)" if episode.held_out else episode.name)
    return on, whole, [list(row) for row in grid]


def _finish(on: Any, grid: Sequence[Sequence[Axes]]) -> None:
    """Make the value axes symmetric about zero, and add the legend."""
    for axes in grid[0]:
        limit = max(map(abs, axes.get_ylim()))
        axes.set_ylim(-limit, limit)
    handles, labels = grid[0][0].get_legend_handles_labels()
    legend(on, handles=handles, labels=labels, loc="outside upper right", ncols=4)
