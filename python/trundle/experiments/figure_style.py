"""Style of the figures of experiments: that of `trundle.plots`, with colours and marks by learner."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from trundle import palette
from trundle.plots.style import legend, plain, save, sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = [
    "COLOURS",
    "GREY",
    "MARKERS",
    "NAMES",
    "OBSERVED",
    "PREDICTED",
    "legend",
    "plain",
    "save",
    "share_limits",
    "sheet",
]

COLOURS = {
    "pbr": palette.AFTER,
    "lr": palette.BEFORE,
    "lwr": palette.MARK,
    "lr_body": "#e0a070",
    "lwr_body": "#d58ab4",
}
"""By learner; also where two models are compared. Lighter colours are the stronger baselines."""
MARKERS = {"pbr": "o", "lr": "s", "lwr": "^", "lr_body": "s", "lwr_body": "^"}
NAMES = {
    "pbr": "PBR",
    "lr": "LR",
    "lwr": "LWR",
    "lr_body": "LR, object axes",
    "lwr_body": "LWR, object axes",
}
OBSERVED = "#2e8b57"
"""Observed motion: green, as in the paper's Fig. 5."""
PREDICTED = COLOURS["pbr"]
GREY = palette.MUTED


def share_limits(axes: Sequence[Axes]) -> None:
    """Give axes the same limits, with equal scales of x and y."""
    x = [limit for one in axes for limit in one.get_xlim()]
    y = [limit for one in axes for limit in one.get_ylim()]
    for one in axes:
        one.set(xlim=(min(x), max(x)), ylim=(min(y), max(y)), aspect="equal")
