"""Identifiability: profile likelihoods of single parameters, and the identifiable directions of a fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle import _native
from trundle._native import Model, Recording, TrundleError
from trundle.display import Card, Displayed, Table
from trundle.display.formatting import format_number
from trundle.native_inputs import PathLike, native_model, native_recording
from trundle.progress import ProgressOption, report_progress

__all__ = ["CHI2_1_QUANTILE_90", "Profile", "format_identifiability", "profile"]

CHI2_1_QUANTILE_90 = 2.705543454
"""90 % quantile of the χ² distribution with one degree of freedom."""


@dataclass(frozen=True, repr=False)
class Profile(Displayed):
    """Profile likelihood of one parameter.

    Attributes
    ----------
    name, unit : str
        The parameter and its SI unit.
    values : array of shape (n,)
        Increasing values of the parameter.
    deviance : array of shape (n,)
        Twice the cost above its minimum; all other parameters are fitted at each value.
    interval : tuple of two floats or None
        Ends of the 90 % interval. An end is None if the deviance does not rise enough within four prior
        standard deviations.
    shape : str
        "two-sided", "at least", "at most" or "flat".
    modes : tuple of floats
        Local optima inside the interval. Several optima are an ambiguity.
    mean, sd : float or None
        The Laplace estimate of the fit, if the parameter is identifiable.

    Examples
    --------
    >>> profile = trundle.profile(recording, "coulomb_friction.force", "free.toml", starts=2)
    >>> profile.shape
    'two-sided'
    >>> low, high = profile.interval
    >>> low < profile.mean < high
    True
    """

    name: str
    unit: str
    values: NDArray[np.float64]
    deviance: NDArray[np.float64]
    interval: tuple[float | None, float | None]
    shape: str
    modes: tuple[float, ...]
    mean: float | None
    sd: float | None

    def __str__(self) -> str:
        """Return a sentence on the interval."""
        low, high = (None if end is None else f"{end:.5g} {self.unit}".rstrip() for end in self.interval)
        text = {
            "two-sided": f"{self.name} lies between {low} and {high}",
            "at least": f"{self.name} is at least {low}; these data determine no upper bound",
            "at most": f"{self.name} is at most {high}; these data determine no lower bound",
        }.get(self.shape, f"{self.name} is not identifiable from these data")
        if self.shape != "flat":
            text += " (90 %)"
        if len(self.modes) > 1:
            text += "; local optima at " + ", ".join(f"{mode:.4g}" for mode in self.modes)
        return text

    def _card(self) -> Card:
        rows = [
            (format_number(value), format_number(deviance))
            for value, deviance in zip(self.values, self.deviance, strict=True)
        ]
        table = Table((f"{self.name}, {self.unit}", "deviance"), rows)
        return Card(f"trundle.Profile: {self}", (), table)

    def plot(self, width: int = 60) -> str:
        """Return a text plot with one line per value: the bar is the deviance, `|` the 90 % threshold."""
        rows = [str(self)]
        scale = width / (3 * CHI2_1_QUANTILE_90)
        mark = round(CHI2_1_QUANTILE_90 * scale)
        for value, deviance in zip(self.values, self.deviance, strict=True):
            bar = "#" * min(width, round(float(deviance) * scale))
            line = bar.ljust(width)
            line = line[:mark] + "|" + line[mark + 1 :]
            rows.append(f"  {value:12.5g} {line.rstrip()}")
        return "\n".join(rows)


def profile(
    recording: Recording | PathLike,
    parameter: str,
    model: Model | PathLike | None = None,
    *,
    prior: PathLike | None = None,
    grid: Sequence[float] | None = None,
    starts: int = 6,
    seed: int = 0,
    progress: ProgressOption = None,
) -> Profile:
    """Compute the profile likelihood of one parameter: fix it at several values and refit the others.

    Parameters
    ----------
    recording : Recording or path
    parameter : str
        A free parameter, named as in the summary of a fit: ``body.mass``.
    model, prior, starts, seed, progress
        As for :func:`trundle.fit`.
    grid : sequence of floats, optional
        Values, SI units. By default they extend from the estimate until the interval is covered.

    Returns
    -------
    Profile

    Raises
    ------
    TrundleError
        If the parameter is not free, or the fit is not possible.

    Examples
    --------
    >>> print(trundle.profile(recording, "coulomb_friction.force", "free.toml", starts=2))
    coulomb_friction.force lies between ... N and ... N (90 %)
    """
    if starts < 1:
        raise TrundleError(f"starts = {starts}: at least one start is needed")
    if grid is not None and not np.isfinite(np.asarray(grid, dtype=float)).all():
        raise TrundleError("grid: every value must be a finite number")
    prior_file = None if prior is None else (str(prior), Path(prior).read_text(encoding="utf-8"))
    with report_progress(progress, "profile") as report:
        answer = _native._profile(
            native_recording(recording),
            parameter,
            native_model(model),
            prior=prior_file,
            grid=None if grid is None else [float(value) for value in grid],
            starts=starts,
            seed=seed,
            progress=report,
        )
    low, high = answer["interval"]
    return Profile(
        name=answer["name"],
        unit=answer["unit"],
        values=np.asarray(answer["values"], dtype=float),
        deviance=np.asarray(answer["deviance"], dtype=float),
        interval=(low, high),
        shape=answer["shape"],
        modes=tuple(answer["modes"]),
        mean=answer["mean"],
        sd=answer["sd"],
    )


def format_identifiability(identifiability: dict[str, Any]) -> list[str]:
    """Format the identifiable directions and combinations of a fit as lines for the terminal."""
    held, total = identifiability["held"], identifiability["of"]
    agreement = identifiability["agreement"]
    rows = [
        f"identifiable directions: {held} of {total} "
        f"({agreement['at_the_optimum']} of {agreement['starts']} starts reached this optimum)"
    ]
    rows += [f"  identifiable combination: {c['text']}" for c in identifiability["combinations"]]
    for direction in identifiability["directions"]:
        if not direction["held"]:
            rows.append(f"  not identifiable: {_format_direction(direction['parts'])}")
    return rows


def _format_direction(parts: list[dict[str, Any]]) -> str:
    return " ".join(
        f"{part['weight']:+.2f}·{part['name']}" if len(parts) > 1 else part["name"] for part in parts
    )
