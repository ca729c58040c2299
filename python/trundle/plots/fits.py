"""Figure of a fit: the fitted model in open loop, compared with the recorded motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from trundle.plots.motion import MotionPanels, simulated
from trundle.plots.selection import PathLike, choose, open_loop, quasi_static_note, read_recording
from trundle.plots.style import heading, on_figure
from trundle.recording import Recording, TrundleError
from trundle.report.quantity import format_quantity
from trundle.report.series import held_out_first

if TYPE_CHECKING:
    from matplotlib.figure import Figure, SubFigure

    from trundle.fitting import Fit

__all__ = ["fit"]

MAX_EPISODES = 6
"""Maximum number of episodes that are drawn by default."""
_COLUMNS = 3
_PLANAR, _RAIL = (11.0, 5.4), (11.0, 3.4)
"""Size of a row of panels, inches."""


def fit(
    fit: Fit,
    recording: Recording | PathLike,
    episodes: str | Sequence[str] | None = None,
    *,
    figure: Figure | SubFigure | None = None,
) -> Figure:
    """Draw the motion that a fitted model predicts in open loop, compared with the recorded motion.

    Parameters
    ----------
    fit : Fit
        Result of `trundle.fit`.
    recording : Recording or path
        Usually the one of the fit; any recording of the same object.
    episodes : str or sequence of str, optional
        Names of episodes. By default up to six, held-out episodes first.
    figure : Figure or SubFigure, optional
        Where to draw; by default a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        One panel per episode: paths from above (position over time on a rail), and the error over time.

    Raises
    ------
    TrundleError
        If an episode does not exist, a parameter of the model has no value, no episode has a simulated
        motion, or matplotlib is missing.

    Examples
    --------
    >>> import trundle
    >>> recording = trundle.simulate("configs/experiments/demo.toml")
    >>> fitted = trundle.fit(recording)  # doctest: +SKIP
    >>> trundle.plots.fit(fitted, recording)  # doctest: +SKIP
    """
    source = read_recording(recording)
    series = open_loop(source, fit.model)
    ordered = held_out_first(series.episodes)
    chosen = choose([each.name for each in ordered], episodes, source.name)
    wanted = chosen[:MAX_EPISODES] if episodes is None else chosen
    by_name = {each.name: each for each in ordered}
    drawn = [by_name[name] for name in wanted if simulated(by_name[name])]
    if not drawn:
        raise TrundleError(f"{source.name}: the model predicts no motion of {', '.join(wanted)}")
    panels = MotionPanels(drawn, series, {"after": "fitted model"})
    columns = min(_COLUMNS, len(drawn))
    rows = -(-len(drawn) // columns)
    width, height = _RAIL if panels.on_rail else _PLANAR
    on, whole = on_figure(figure, (max(5.5, width * columns / _COLUMNS), 0.8 + height * rows))
    grid = on.add_gridspec(rows, columns)
    panels.draw(on, [grid[index // columns, index % columns] for index in range(len(drawn))])
    shown = "" if len(drawn) == len(ordered) else f"{len(drawn)} of {len(ordered)} episodes are shown."
    note = quasi_static_note(fit.summary)
    heading(on, f"{source.name}: fitted model in open loop", _errors(fit.summary), shown, note)
    return whole


def _errors(summary: Any) -> str:
    """Return a sentence on the errors in the summary of a fit; empty without any."""
    parts = []
    for key, name in (("training", "training"), ("held_out", "held out")):
        found = (summary.get(key) or {}).get("position_rmse")
        if found is not None:
            parts.append(f"{name} {format_quantity('m', found)}")
    return f"Position error of the fit (RMS, whole episodes): {', '.join(parts)}." if parts else ""
