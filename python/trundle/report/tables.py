"""The numbers: figures of fit, parameters, candidates, windows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report import words
from trundle.report.given import Series, finite
from trundle.report.markup import Child, Html, tag
from trundle.report.parameter import parameter
from trundle.report.quantity import ABSENT, interval, readable, significant, suited
from trundle.report.verdict import before_after

__all__ = ["candidates", "fit", "nominal", "parameters", "ranked", "table", "windows"]

_FIGURES = (
    ("position_rmse", "position, whole episodes (rms)", "m"),
    ("final_position_error", "position at the end (mean)", "m"),
    ("window_position_rmse", "position, 1 s ahead (rms)", "m"),
    ("heading_rmse", "heading, whole episodes (rms)", "rad"),
    ("final_heading_error", "heading at the end (mean)", "rad"),
    ("window_heading_rmse", "heading, 1 s ahead (rms)", "rad"),
    ("r2", "R² of the motion", ""),
    ("force_rmse", "force needed less recorded (rms)", "N"),
    ("torque_rmse", "torque needed less recorded (rms)", "N·m"),
    ("force_bandwidth", "both of these below", "Hz"),
    ("log_predictive_density", "log predictive density per sample", ""),
)
_SIDES = ("before", "after")


def table(head: Sequence[Child], rows: Sequence[Sequence[Child]], style: str = "") -> Html:
    """Return a table whose first column names the row."""
    top = tag("thead", tag("tr", [tag("th", cell, scope="col") if cell else tag("td") for cell in head]))
    body = [tag("tr", tag("th", row[0], scope="row"), [tag("td", cell) for cell in row[1:]]) for row in rows]
    return tag("div", tag("table", top, tag("tbody", body), class_=style or None), class_="wide")


def fit(scores: Mapping[str, Any], series: Series, single: bool = False, without: str | None = None) -> Html:
    """Figures but for `without`, before and after or in one column; a dash where there is none, and why."""
    sides = _SIDES[:1] if single else _SIDES
    rows: list[list[Child]] = []
    reasons: list[str] = []
    for key, name, unit in _FIGURES:
        if key == without:
            continue
        values = before_after(scores, key)[: len(sides)]
        scale = suited(unit, *values)
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
    """Return the mark of a reason: a figure would read as an exponent."""
    return chr(ord("a") + index)


def _reason(key: str, side: str, series: Series) -> str:
    if (
        key in ("heading_rmse", "final_heading_error", "window_heading_rmse", "torque_rmse")
        and "theta" not in series.dof
    ):
        return "there is no heading on a rail"
    if key == "force_bandwidth" and series.quasi_static:
        return "no acceleration is needed where wrenches alone are compared"
    if series.quasi_static and key not in ("force_rmse", "torque_rmse"):
        return "slow pushes hold no mass: no motion can be simulated, so the wrench is compared"
    return "no richer model was adopted" if side == "after" else "this recording does not hold it"


def nominal(given: Mapping[str, Any]) -> Html | None:
    """Parameters of the simulation under test: as given, and refitted before and after."""
    columns = {side: given.get(side) or {} for side in ("given", *_SIDES)}
    if columns["after"] == columns["before"]:
        columns["after"] = {}
    shown = [side for side, values in columns.items() if values]
    names = list(dict.fromkeys(name for side in (*_SIDES, "given") for name in columns[side]))
    if not names:
        return None
    rows = [[tag("code", name), *(parameter(columns[side].get(name)) for side in shown)] for name in names]
    heads = ("refitted" if side == "before" and not columns["after"] else side for side in shown)
    return table(("", *heads), rows, "stacked")


def parameters(given: Mapping[str, Any]) -> Html | None:
    """Return the parameters of one effect."""
    rows = [[readable(name), parameter(value)] for name, value in given.items()]
    return table(("", "value"), rows, "parameters") if rows else None


def candidates(ranking: Sequence[Mapping[str, Any]]) -> list[list[Child]]:
    """Return a row for each explanation; evidence relative to the best."""
    evidence = [value for entry in ranking if (value := finite(entry.get("log_evidence"))) is not None]
    best = max(evidence, default=0.0)
    titles = [_title(entry) for entry in ranking]
    again = [title in titles[:index] for index, title in enumerate(titles)]
    return [
        [[title, ", in another form" if twin else None], *_candidate(entry, best)]
        for title, twin, entry in zip(titles, again, ranking, strict=True)
    ]


def ranked(rows: Sequence[Sequence[Child]]) -> Html:
    """Return a table of some of the rows that `candidates` made."""
    head = ("added to the simulation", "log evidence", "log score", "not named because")
    columns = len(head) if any(row[-1] is not None for row in rows) else len(head) - 1
    return table(head[:columns], [row[:columns] for row in rows], "tried")


def _title(entry: Mapping[str, Any]) -> Child:
    names = entry.get("effects") or ()
    return words.effects(names) if names else tag("em", "nothing (as given)")


def _candidate(entry: Mapping[str, Any], best: float) -> list[Child]:
    evidence, score = finite(entry.get("log_evidence")), finite(entry.get("log_score"))
    behind = ABSENT if evidence is None else "best" if evidence == best else significant(evidence - best)
    reason = tag("span", str(entry["reason"]), class_="prose") if entry.get("reason") else None
    return [behind, ABSENT if score is None else significant(score, 4), reason]


def windows(given: Sequence[Mapping[str, Any]]) -> Html | None:
    """Where the simulation as given goes wrong in time."""
    rows: list[list[Child]] = []
    for window in given:
        start, end, strength = (finite(window.get(key)) for key in ("start", "end", "strength"))
        span = ABSENT if start is None or end is None else interval(start, end)
        rows.append(
            [str(window.get("episode")), span, ABSENT if strength is None else ["10", _raised(-strength)]]
        )
    return table(("episode", "when", "chance by noise alone"), rows) if rows else None


def _raised(exponent: float) -> Html:
    return tag("sup", f"{exponent:.0f}".replace("-", "\N{MINUS SIGN}"))
