"""Tables of errors, intervals and probabilities on a blind benchmark's page."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from trundle.experiments.blind import reliability
from trundle.experiments.blind.errors import coverage, meets_target, parameter_errors, place_errors
from trundle.experiments.blind.score import named_probabilities
from trundle.experiments.blind.tables import engines_of
from trundle.experiments.markdown import table
from trundle.experiments.results import Row
from trundle.experiments.statistics import calibration, median, share

__all__ = ["intervals", "parameters", "places", "platt_text", "probabilities", "score_text"]


def places(rows: Sequence[Row]) -> str:
    """Return the errors of places and times by effect."""
    lines = []
    for kind, found in place_errors(rows).items():
        for effect in sorted({effect for effect, _ in found}):
            values = [value for name, value in found if name == effect]
            reached = share(meets_target(kind, value) for value in values)
            lines.append([kind, f"`{effect}`", median(values).text(".2g", "not given"), reached.text()])
    return table(["place", "effect", "median", "within"], lines)


def parameters(rows: Sequence[Row]) -> str:
    """Return relative errors of values, and the coverage of intervals of two standard deviations."""
    lines = []
    for name, errors in sorted(parameter_errors(rows).items()):
        sizes = [size for size, _ in errors if math.isfinite(size)]
        held = share(z <= 2.0 for _, z in errors if math.isfinite(z))
        lines.append([f"`{name}`", median(sizes).text(".2g") if sizes else "–", held.text()])
    return table(["value", "relative error, median", "within 2 sd"], lines)


def intervals(rows: Sequence[Row]) -> str:
    """Return the coverage of 90 % intervals, pooled and by effect and engine."""
    engines = engines_of(rows)
    found = [(effect, held, row["truth"]["engine"]) for row in rows for effect, held in coverage(row)]
    lines = []
    for effect in ("all", *sorted({effect for effect, _, _ in found})):
        mine = [(held, engine) for name, held, engine in found if effect in (name, "all")]
        parts = [share(held for held, one in mine if one == engine).text() for engine in engines]
        lines.append([effect, share(held for held, _ in mine).text(), *parts])
    return table(["effect", "all", *engines], lines)


def named(rows: Sequence[Row]) -> list[tuple[float, bool]]:
    """Return the probability of each name, and whether it is present."""
    return [one for row in rows for one in named_probabilities(row["answer"], row["truth"])]


def probabilities(rows: Sequence[Row]) -> str:
    """Return the calibration of the probabilities of all names."""
    lines = [[f"{mean:.3f}", held.text()] for mean, held in calibration(named(rows))]
    return table(["mean probability", "correct"], lines) if lines else "No effect was named."


def score_text(rows: Sequence[Row]) -> str:
    """Return Brier and log score of the probabilities against the base rate."""
    found = named(rows)
    if not found:
        return ""
    base = sum(held for _, held in found) / len(found)
    scores = [probability_scores(found), probability_scores([(base, held) for _, held in found])]
    text = "Brier score {0[0]:.4f} (base rate {1[0]:.4f}), log score {0[1]:.4f} (base rate {1[1]:.4f})."
    return text.format(*scores)


def probability_scores(found: Sequence[tuple[float, bool]]) -> tuple[float, float]:
    """Return Brier score and mean negative log probability, with probabilities of at least 10⁻⁶."""
    p, held = np.array(found, dtype=float).T
    right = np.clip(np.where(held > 0.0, p, 1.0 - p), 1e-6, 1.0)
    return float(np.mean((p - held) ** 2)), float(np.mean(-np.log(right)))


def platt_text(rows: Sequence[Row]) -> str:
    """Return the parameters of Platt's method fitted to these answers."""
    used = reliability.current_platt()
    found = reliability.fit_platt(rows, used)
    if found is None:
        return ""
    text = (
        "Platt's method, each kind of recording at its prevalence, gives offset {0.offset:.3f}, slope "
        "{0.slope:.3f} and bound {0.most:.2f}; in use are {1.offset:.3f}, {1.slope:.3f} and {1.most:.2f}. "
        "The highest probability is then {2:.3f}, in use {3:.3f}."
    )
    return text.format(found, used, found.probability(found.most), used.probability(used.most))
