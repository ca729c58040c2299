"""Elements of axes over time: labels with display units, noise bands, windows and events."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from trundle import palette
from trundle.plots.style import plain
from trundle.report.quantity import Scale, display_scale
from trundle.report.series import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["common_scale", "draw_band", "draw_contact", "draw_marks", "label_lanes", "reach"]


def reach(curves: Sequence[Array]) -> float:
    """Return the largest finite magnitude of some curves; 1 if there is none or all are zero."""
    values = np.concatenate([np.ravel(curve) for curve in curves]) if curves else np.empty(0)
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0)) or 1.0


def common_scale(unit: str, curves: Sequence[Array]) -> Scale:
    """Return the display unit that suits all curves: mm, cm or m for "m", degrees for "rad"."""
    return display_scale(unit, reach(curves))


def draw_band(axes: Axes, t: Array, sd: Array) -> None:
    """Shade two standard deviations (n,) of the noise about zero."""
    label = "noise (two standard deviations)"
    axes.fill_between(t, -2.0 * sd, 2.0 * sd, color=palette.RECORDED, alpha=0.35, linewidth=0, label=label)


def draw_contact(axes: Axes, contact: float) -> None:
    """Mark the start of contact, s."""
    if np.isfinite(contact):
        axes.axvline(contact, color=palette.MUTED, linewidth=0.9, linestyle=":")


def draw_marks(
    axes: Axes, windows: Sequence[tuple[float, float]], events: Sequence[tuple[float, str]] = ()
) -> None:
    """Shade windows, s, that exceed the noise, and mark events (time, number of the effect)."""
    for start, end in windows:
        axes.axvspan(start, end, color=palette.WINDOW, alpha=0.55, linewidth=0, zorder=0.5)
    for time, number in events:
        axes.axvline(time, color=palette.MARK, linewidth=1.2, linestyle="-.", label=f"effect {number}")


def label_lanes(axes: Sequence[Axes], names: Sequence[str]) -> None:
    """Name the value axes of lanes that share the time axis, which only the last one labels."""
    for one, name in zip(axes, names, strict=True):
        plain(one)
        one.set_ylabel(name)
        one.tick_params(labelbottom=one is axes[-1])
    axes[-1].set_xlabel("time (s)")
