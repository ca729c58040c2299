"""Rows of the tables of error metrics, parameters, candidates, windows and immaterial effects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report import wording
from trundle.report.parameter import Quantity, format_parameter
from trundle.report.quantity import ABSENT, display_scale, format_interval, format_significant, key_to_words
from trundle.report.results import results
from trundle.report.series import Series, finite
from trundle.report.verdict import before_after

__all__ = [
    "candidates",
    "effect_parameters",
    "immaterial_effects",
    "metrics",
    "nominal_parameters",
    "windows",
]

Row = dict[str, Any]

_METRICS = (
    ("position_rmse", "position, whole episodes (RMS)", "m"),
    ("final_position_error", "final position (mean)", "m"),
    ("window_position_rmse", "position, 1 s ahead (RMS)", "m"),
    ("heading_rmse", "heading, whole episodes (RMS)", "rad"),
    ("final_heading_error", "final heading (mean)", "rad"),
    ("window_heading_rmse", "heading, 1 s ahead (RMS)", "rad"),
    ("r2", "R² of the motion", ""),
    ("force_rmse", "required minus recorded force (RMS)", "N"),
    ("torque_rmse", "required minus recorded torque (RMS)", "N·m"),
    ("force_bandwidth", "bandwidth of force and torque", "Hz"),
    ("log_predictive_density", "log predictive density per sample", ""),
)
"""Error metrics: key of diagnosis.json, text, unit."""
_SIDES = ("before", "after")


def metrics(
    scores: Mapping[str, Any], series: Series, single: bool = False, without: str | None = None
) -> Row:
    """Return columns, rows and notes of the error metrics; an absent metric has a note on the reason.

    Parameters
    ----------
    scores
        Metrics by side ("before", "after") and key.
    series
        For the degrees of freedom.
    single
        There is one simulation, hence one column.
    without
        Key of a metric to omit.
    """
    sides = _SIDES[:1] if single else _SIDES
    rows = []
    reasons: list[str] = []
    for key, name, unit in _METRICS:
        if key == without:
            continue
        values = before_after(scores, key)[: len(sides)]
        scale = display_scale(unit, *values)
        marks = [
            "" if value is not None else _mark(_reason(key, side, series), reasons)
            for side, value in zip(sides, values, strict=True)
        ]
        texts = [scale.text(value, None if unit else 4) for value in values]
        rows.append((name, list(zip(texts, marks, strict=True))))
    notes = [(_letter(index), reason) for index, reason in enumerate(reasons)]
    return {"columns": ["simulation"] if single else list(sides), "rows": rows, "notes": notes}


def _mark(reason: str, reasons: list[str]) -> str:
    if reason not in reasons:
        reasons.append(reason)
    return _letter(reasons.index(reason))


def _letter(index: int) -> str:
    """Return the mark of a note, a letter because a digit would read as an exponent."""
    return chr(ord("a") + index)


def _reason(key: str, side: str, series: Series) -> str:
    if (
        key in ("heading_rmse", "final_heading_error", "window_heading_rmse", "torque_rmse")
        and "theta" not in series.dof
    ):
        return "there is no heading on a rail"
    if key == "force_bandwidth" and series.quasi_static:
        return "only wrenches are compared, which requires no acceleration"
    if key == "log_predictive_density" and series.is_black_box:
        return "a black-box simulator has no predictive density"
    if series.is_black_box and key in ("force_rmse", "torque_rmse", "force_bandwidth"):
        return "a black-box simulator does not give the wrench that a motion requires"
    if series.quasi_static and key not in ("force_rmse", "torque_rmse"):
        return (
            "quasi-static pushes do not determine the mass, so the wrench is compared instead of the motion"
        )
    return "no effect was added" if side == "after" else "this recording does not determine it"


def nominal_parameters(given: Mapping[str, Any]) -> Row | None:
    """Return head and rows of the parameters under test: given, and refitted before and after."""
    columns = {side: given.get(side) or {} for side in ("given", *_SIDES)}
    if columns["after"] == columns["before"]:
        columns["after"] = {}
    shown = [side for side, values in columns.items() if values]
    names = list(dict.fromkeys(name for side in (*_SIDES, "given") for name in columns[side]))
    if not names:
        return None
    heads = ["refitted" if side == "before" and not columns["after"] else side for side in shown]
    rows = [(name, [format_parameter(columns[side].get(name)) for side in shown]) for name in names]
    return {"head": ["", *heads], "rows": rows}


def effect_parameters(given: Mapping[str, Any]) -> list[tuple[str, list[Quantity]]]:
    """Return a row for each parameter of an effect."""
    return [(key_to_words(name), [format_parameter(value)]) for name, value in given.items()]


def candidates(diagnosis: Mapping[str, Any], ranking: Sequence[Mapping[str, Any]]) -> list[Row]:
    """Return a row for each candidate, with its log evidence relative to the best, and the result."""
    evidence = [value for entry in ranking if (value := finite(entry.get("log_evidence"))) is not None]
    best = max(evidence, default=0.0)
    effects = [wording.effect_names(entry.get("effects") or ()) for entry in ranking]
    return [
        {
            "effects": names,
            "is_repeated": names in effects[:index],
            "result": result,
            **_candidate(entry, best),
        }
        for index, (names, entry, result) in enumerate(
            zip(effects, ranking, results(diagnosis, ranking), strict=True)
        )
    ]


def _candidate(entry: Mapping[str, Any], best: float) -> Row:
    evidence, score = finite(entry.get("log_evidence")), finite(entry.get("log_score"))
    behind = (
        ABSENT if evidence is None else "best" if evidence == best else format_significant(evidence - best)
    )
    return {
        "evidence": behind,
        "evidence_value": "" if evidence is None else evidence - best,
        "score": ABSENT if score is None else format_significant(score, 4),
    }


def windows(given: Sequence[Mapping[str, Any]]) -> list[Row]:
    """Return a row for each window that noise does not explain."""
    rows = []
    for window in given:
        start, end, strength = (finite(window.get(key)) for key in ("start", "end", "strength"))
        rows.append(
            {
                "episode": str(window.get("episode")),
                "time": ABSENT if start is None or end is None else format_interval(start, end),
                "strength": "" if strength is None else -strength,
                "exponent": "" if strength is None else f"{-strength:.0f}".replace("-", "\N{MINUS SIGN}"),
            }
        )
    return rows


def immaterial_effects(diagnosis: Mapping[str, Any]) -> list[Row]:
    """Return a row for each effect that the data show but that barely improves predictions."""
    return [
        {
            "name": wording.capitalise(wording.effect_name(effect.get("effect"))),
            "statement": wording.typeset(effect.get("statement") or ""),
            "probability": wording.format_share(effect.get("probability")) or ABSENT,
        }
        for effect in diagnosis.get("immaterial") or ()
        if isinstance(effect, Mapping)
    ]
