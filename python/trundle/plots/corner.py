"""Figure of a posterior: marginal distributions, and draws of each pair of parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from trundle import palette
from trundle._optional import require
from trundle.plots.style import heading, legend, on_figure, plain
from trundle.recording import TrundleError
from trundle.report.quantity import format_estimate
from trundle.report.series import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

    from trundle.posterior import Posterior

__all__ = ["posterior"]

MAX_PARAMETERS = 8
"""Maximum number of parameters that are drawn by default."""
_PANEL = 1.55
"""Size of a panel, inches."""
_SHARES = (0.9, 0.5)
"""Probabilities inside the contours of a pair."""


def posterior(
    posterior: Posterior,
    parameters: Sequence[str] | None = None,
    *,
    figure: Figure | SubFigure | None = None,
) -> Figure:
    """Draw the marginal distribution of each parameter, and the draws of each pair.

    Parameters
    ----------
    posterior : Posterior
        Result of `trundle.sample`.
    parameters : sequence of str, optional
        Names of parameters. By default the first eight that are identifiable.
    figure : Figure or SubFigure, optional
        Where to draw; by default a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        On the diagonal: all draws (filled), each chain (thin lines, except for a Laplace approximation), and
        the central 90 % interval. Below it: draws with contours that contain 50 % and 90 % of them.

    Raises
    ------
    TrundleError
        If a parameter does not exist, none is identifiable, or matplotlib is missing.

    Examples
    --------
    >>> import trundle
    >>> drawn = trundle.sample("recordings/run_3")  # doctest: +SKIP
    >>> trundle.plots.posterior(drawn)  # doctest: +SKIP
    """
    described = {entry["name"]: entry for entry in posterior.summary["parameters"]}
    names = _choose(described, parameters)
    draws = {name: np.asarray(posterior.draws[name], dtype=np.float64) for name in names}
    size = max(6.0, _PANEL * len(names) + 0.8)
    on, whole = on_figure(figure, (size, size + 0.3))
    grid = on.subplots(len(names), len(names), squeeze=False, sharex="col")
    by_chain = posterior.summary["method"] != "laplace"
    for row, name in enumerate(names):
        _draw_marginal(grid[row, row], draws[name], described[name], by_chain)
        for column in range(len(names)):
            if column < row:
                _draw_pair(grid[row, column], draws[names[column]], draws[name])
            elif column > row:
                grid[row, column].set_axis_off()
    _label(grid, names, described)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    legend(on, handles=handles, labels=labels, loc="outside upper right", ncols=3)
    chains, count = draws[names[0]].shape
    left_out = len(described) - len(names)
    note = f"{left_out} other {'parameter is' if left_out == 1 else 'parameters are'} not shown."
    heading(
        on,
        f"{posterior.summary['recording']}: posterior",
        f"{chains} chains of {count} draws.",
        f"{posterior.summary['verdict'][:1].upper()}{posterior.summary['verdict'][1:]}.",
        f"Contours contain {100 * _SHARES[1]:.0f} % and {100 * _SHARES[0]:.0f} % of the draws.",
        note if left_out else "",
    )
    return whole


def _choose(described: Mapping[str, Mapping[str, Any]], wanted: Sequence[str] | None) -> list[str]:
    if wanted is None:
        names = [name for name, entry in described.items() if entry["identifiable"]][:MAX_PARAMETERS]
        if not names:
            raise TrundleError("posterior: no parameter is identifiable; name those to draw in `parameters`")
        return names
    names = [wanted] if isinstance(wanted, str) else list(wanted)
    for name in names:
        if name not in described:
            raise TrundleError(f"no parameter `{name}`; the parameters are {', '.join(described)}")
    if not names:
        raise TrundleError("parameters: name at least one, or use None for all identifiable ones")
    return names


def _draw_marginal(axes: Axes, draws: Array, described: Mapping[str, Any], by_chain: bool) -> None:
    """Draw the density of all draws (chain, draw), of each chain, and the 90 % interval."""
    count = min(40, max(10, int(np.sqrt(draws.size))))
    bins = np.histogram_bin_edges(draws, bins=count).tolist()
    axes.hist(draws.ravel(), bins=bins, density=True, color=palette.AFTER, alpha=0.3, label="all draws")
    if by_chain:
        for index, chain in enumerate(draws):
            label = "one chain" if index == 0 else "_"
            axes.hist(
                chain,
                bins=bins,
                density=True,
                histtype="step",
                color=palette.MUTED,
                linewidth=0.6,
                label=label,
            )
    low, high = np.quantile(draws, [0.05, 0.95])
    base: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "color": palette.AFTER, "linewidth": 3.0}
    axes.plot([low, high], [0.0, 0.0], label="90 % interval", clip_on=False, **base)
    estimate = format_estimate(draws.mean(), draws.std(), str(described["unit"]))
    axes.set_title(estimate, fontsize=8, color=palette.INK)


def _draw_pair(axes: Axes, x: Array, y: Array) -> None:
    """Draw the draws of two parameters, (chain, draw) each, and contours of their density."""
    axes.plot(
        x.ravel(),
        y.ravel(),
        ".",
        color=palette.AFTER,
        markersize=1.8,
        alpha=0.35,
        rasterized=True,
        linewidth=0,
    )
    density, x_centres, y_centres = _density(x.ravel(), y.ravel())
    levels = _levels(density)
    if len(levels) > 1:
        axes.contour(x_centres, y_centres, density.T, levels=levels, colors=palette.INK, linewidths=0.8)


def _density(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Return a smoothed histogram (n, n) of two parameters and the centres of its bins."""
    bins = int(np.clip(1.2 * len(x) ** 0.35, 8, 30))
    reach = [(v.min() - 0.15 * np.ptp(v) - 1e-12, v.max() + 0.15 * np.ptp(v) + 1e-12) for v in (x, y)]
    counts, *edges = np.histogram2d(x, y, bins=bins, range=reach)
    kernel = np.array([1.0, 2.0, 1.0]) / 4.0
    for axis in (0, 1):
        counts = np.apply_along_axis(lambda row: np.convolve(row, kernel, mode="same"), axis, counts)
    centres = [0.5 * (edge[1:] + edge[:-1]) for edge in edges]
    return counts, centres[0], centres[1]


def _levels(density: Array) -> list[float]:
    """Return the increasing levels whose regions contain `_SHARES` of the draws."""
    ordered = np.sort(density.ravel())[::-1]
    inside = np.cumsum(ordered) / ordered.sum()
    found = {float(ordered[int(np.searchsorted(inside, share))]) for share in _SHARES}
    return sorted(level for level in found if 0.0 < level < ordered[0])


def _label(grid: Any, names: Sequence[str], described: Mapping[str, Mapping[str, Any]]) -> None:
    """Label rows and columns by parameter and unit."""
    ticker = require("matplotlib.ticker", "plots", "plots")
    for row, name in enumerate(names):
        text = name.replace(".", "\n", 1) + _unit(described[name])
        grid[-1, row].set_xlabel(text)
        for column in range(row + 1):
            axes: Axes = grid[row, column]
            plain(axes)
            axes.xaxis.set_major_locator(ticker.MaxNLocator(3))
            axes.yaxis.set_major_locator(ticker.MaxNLocator(3))
            axes.ticklabel_format(useOffset=False)
            axes.tick_params(
                labelsize=7, labelleft=column == 0 and row > 0, labelbottom=row == len(names) - 1
            )
            axes.tick_params(axis="x", labelrotation=35)
        if row > 0:
            grid[row, 0].set_ylabel(text)
        grid[row, row].set_yticks([])
        grid[row, row].title.set_fontsize(8)


def _unit(entry: Mapping[str, Any]) -> str:
    return f" ({entry['unit']})" if entry["unit"] not in ("", "1") else ""
