"""Tables of error metrics, parameters, candidates and windows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report import wording
from trundle.report.markup import Child, Html, tag
from trundle.report.parameter import format_parameter
from trundle.report.quantity import ABSENT, display_scale, format_interval, format_significant, key_to_words
from trundle.report.series import Series, finite
from trundle.report.verdict import before_after

__all__ = [
    "candidate_rows",
    "candidate_table",
    "effect_parameters",
    "metrics",
    "nominal_parameters",
    "table",
    "windows",
]

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


def table(head: Sequence[Child], rows: Sequence[Sequence[Child]], style: str = "") -> Html:
    """Return a table whose first column is the header of each row."""
    top = tag("thead", tag("tr", [tag("th", cell, scope="col") if cell else tag("td") for cell in head]))
    body = [tag("tr", tag("th", row[0], scope="row"), [tag("td", cell) for cell in row[1:]]) for row in rows]
    return tag("div", tag("table", top, tag("tbody", body), class_=style or None), class_="wide")


def metrics(
    scores: Mapping[str, Any], series: Series, single: bool = False, without: str | None = None
) -> Html:
    """Return a table of error metrics; an absent metric is a dash with a note on the reason.

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
    rows: list[list[Child]] = []
    reasons: list[str] = []
    for key, name, unit in _METRICS:
        if key == without:
            continue
        values = before_after(scores, key)[: len(sides)]
        scale = display_scale(unit, *values)
        marks = [
            _mark(_reason(key, side, series), reasons) if value is None else None
            for side, value in zip(sides, values, strict=True)
        ]
        rows.append(
            [
                name,
                *(
                    [scale.text(value, None if unit else 4), mark]
                    for value, mark in zip(values, marks, strict=True)
                ),
            ]
        )
    notes = [tag("li", tag("sup", _letter(index)), f" {reason}") for index, reason in enumerate(reasons)]
    return tag(
        "div",
        table(("", *(("simulation",) if single else sides)), rows, "figures"),
        tag("ul", notes, class_="notes") if notes else None,
    )


def _mark(reason: str, reasons: list[str]) -> Html:
    if reason not in reasons:
        reasons.append(reason)
    return tag("sup", _letter(reasons.index(reason)))


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
    if series.quasi_static and key not in ("force_rmse", "torque_rmse"):
        return (
            "quasi-static pushes do not determine the mass, so the wrench is compared instead of the motion"
        )
    return "no effect was added" if side == "after" else "this recording does not determine it"


def nominal_parameters(given: Mapping[str, Any]) -> Html | None:
    """Return the parameters of the simulation under test: given, and refitted before and after."""
    columns = {side: given.get(side) or {} for side in ("given", *_SIDES)}
    if columns["after"] == columns["before"]:
        columns["after"] = {}
    shown = [side for side, values in columns.items() if values]
    names = list(dict.fromkeys(name for side in (*_SIDES, "given") for name in columns[side]))
    if not names:
        return None
    rows = [
        [tag("code", name), *(format_parameter(columns[side].get(name)) for side in shown)] for name in names
    ]
    heads = ("refitted" if side == "before" and not columns["after"] else side for side in shown)
    return table(("", *heads), rows, "stacked")


def effect_parameters(given: Mapping[str, Any]) -> Html | None:
    """Return the table of an effect's parameters; None if it has none."""
    rows = [[key_to_words(name), format_parameter(value)] for name, value in given.items()]
    return table(("", "value"), rows, "parameters") if rows else None


def candidate_rows(ranking: Sequence[Mapping[str, Any]]) -> list[list[Child]]:
    """Return a row for each candidate, with its log evidence relative to the best."""
    evidence = [value for entry in ranking if (value := finite(entry.get("log_evidence"))) is not None]
    best = max(evidence, default=0.0)
    titles = [_title(entry) for entry in ranking]
    repeated = [title in titles[:index] for index, title in enumerate(titles)]
    return [
        [[title, " (another form)" if is_repeated else None], *_candidate(entry, best)]
        for title, is_repeated, entry in zip(titles, repeated, ranking, strict=True)
    ]


def candidate_table(rows: Sequence[Sequence[Child]]) -> Html:
    """Return a table of rows of `candidate_rows`."""
    head = ("added to the simulation", "log evidence", "log score", "reason not named")
    columns = len(head) if any(row[-1] is not None for row in rows) else len(head) - 1
    return table(head[:columns], [row[:columns] for row in rows], "tried")


def _title(entry: Mapping[str, Any]) -> Child:
    names = entry.get("effects") or ()
    return wording.effect_names(names) if names else tag("em", "none (as given)")


def _candidate(entry: Mapping[str, Any], best: float) -> list[Child]:
    evidence, score = finite(entry.get("log_evidence")), finite(entry.get("log_score"))
    behind = (
        ABSENT if evidence is None else "best" if evidence == best else format_significant(evidence - best)
    )
    reason = tag("span", str(entry["reason"]), class_="prose") if entry.get("reason") else None
    return [behind, ABSENT if score is None else format_significant(score, 4), reason]


def windows(given: Sequence[Mapping[str, Any]]) -> Html | None:
    """Return the table of windows that noise does not explain; None if there are none."""
    rows: list[list[Child]] = []
    for window in given:
        start, end, strength = (finite(window.get(key)) for key in ("start", "end", "strength"))
        span = ABSENT if start is None or end is None else format_interval(start, end)
        rows.append(
            [
                str(window.get("episode")),
                span,
                ABSENT if strength is None else ["10", _superscript(-strength)],
            ]
        )
    return table(("episode", "time", "probability under noise alone"), rows) if rows else None


def _superscript(exponent: float) -> Html:
    return tag("sup", f"{exponent:.0f}".replace("-", "\N{MINUS SIGN}"))
