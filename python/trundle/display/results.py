"""Cards of fits, diagnoses and posteriors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from trundle.display.card import Card, Table
from trundle.display.formatting import format_change, format_number
from trundle.report.parameter import format_parameter
from trundle.report.quantity import format_estimate, format_point
from trundle.report.wording import effect_name, effect_names, format_share

__all__ = ["diagnosis_card", "fit_card", "joint_diagnosis_card", "posterior_card"]

METRICS = {
    "position_rmse": ("position, whole episodes", "m"),
    "window_position_rmse": ("position, 1 s ahead", "m"),
    "force_rmse": ("required minus recorded force", "N"),
}
"""Error metrics: key, text, unit."""

PARAMETER_HEADS = ("parameter", "estimate", "90 % interval", "unit")
NOT_IDENTIFIABLE = "not identifiable"


def fit_card(summary: Mapping[str, Any]) -> Card:
    """Return the card of a fit from its summary."""
    facts = [("model", describe_lack_of_fit(summary["lack_of_fit"]))]
    if not summary["converged"]:
        facts.append(("search", "NOT CONVERGED: use more starts"))
    facts += [
        (part.replace("_", " "), errors)
        for part in ("training", "held_out")
        if (errors := _errors(summary[part]))
    ]
    rows = [_parameter(parameter) for parameter in summary["parameters"]]
    return Card(f"trundle.Fit to {summary['recording']!r}", facts, Table(PARAMETER_HEADS, rows))


def describe_lack_of_fit(lack: Mapping[str, Any] | None) -> str:
    """Return a phrase on the result of the lack-of-fit test."""
    if lack is None:
        return "lack of fit not tested (only the default likelihood of motion has a test)"
    if not lack["found"]:
        return "explains these data (no lack of fit found)"
    return (
        f"does NOT explain these data: residual {lack['residual_force_rms']:.3g} N and "
        f"{lack['residual_torque_rms']:.3g} N·m rms; run trundle.diagnose"
    )


def _errors(score: Mapping[str, Any] | None) -> str:
    known = [(text, score[key], unit) for key, (text, unit) in METRICS.items() if score and score.get(key)]
    return "; ".join(f"{text} {format_number(value, 3)} {unit}" for text, value, unit in known)


def _parameter(parameter: Mapping[str, Any]) -> tuple[str, str, str, str]:
    name, unit = parameter["name"], parameter["unit"]
    if not parameter["identifiable"]:
        return name, NOT_IDENTIFIABLE, "", unit
    low, high = (format_number(parameter[end]) for end in ("low", "high"))
    return name, format_estimate(parameter["mean"], parameter["sd"]), f"{low} to {high}", unit


def diagnosis_card(answer: Mapping[str, Any]) -> Card:
    """Return the card of a diagnosis from its answer."""
    facts = []
    if answer["verdict"] == "unexplained":
        facts.append(("missing", "something that no effect of the catalogue explains; see the report"))
    elif not answer["missing"]:
        facts.append(("missing", "nothing"))
    if answer.get("tied"):
        tied = "; ".join(effect_names(names, "or") for names in answer["tied"])
        facts.append(("indistinguishable", tied))
    if answer.get("immaterial"):
        found = effect_names([effect["effect"] for effect in answer["immaterial"]])
        facts.append(("detectable, immaterial", found))
    facts += _before_after(answer["fit"])
    rows = [row for effect in answer["missing"] for row in _effect(effect)]
    title = f"trundle.Diagnosis of {answer['recording']!r}: {answer['verdict']}"
    return Card(title, facts, Table(("missing effect", "probability", "parameter", "value"), rows))


def joint_diagnosis_card(answer: Mapping[str, Any]) -> Card:
    """Return the card of a diagnosis of joints from its answer."""
    facts = []
    if answer["verdict"] == "unexplained":
        facts.append(("missing", "something that no effect of the catalogue explains; see the report"))
    elif not answer["missing"]:
        facts.append(("missing", "nothing"))
    if answer["tied"]:
        facts.append(("indistinguishable", "; ".join(" or ".join(names) for names in answer["tied"])))
    part = "held_out" if answer["fit"]["held_out"] else "training"
    pair = answer["fit"][part]
    if pair:
        for key, text in JOINT_METRICS.items():
            before, after = (pair[side][key] for side in ("before", "after"))
            if before is not None:
                facts.append((part.replace("_", " "), f"{text}: {format_change(before, after, '')}".rstrip()))
    rows = [
        (head, format_share(one["probability"]) if k == 0 else "", name, _value(value))
        for one in answer["missing"]
        for head in [":".join([one["effect"], *(one["where"] or {}).values()])]
        for k, (name, value) in enumerate(one["parameters"].items())
    ]
    title = f"trundle.JointDiagnosis of {answer['recording']!r}: {answer['verdict']}"
    return Card(title, facts, Table(("missing effect", "probability", "parameter", "value"), rows))


JOINT_METRICS = {
    "relative_position_rmse": "position, whole episodes, share of the range",
    "relative_window_rmse": "position, 1 s ahead, share of the range",
    "relative_effort_rmse": "required minus recorded effort, share of the range",
}
"""Error metrics of recordings of joints: key, text."""


def _before_after(fit: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the error metrics before and after, of held-out episodes if there are any."""
    part = "held_out" if fit.get("held_out") else "training"
    pair = fit.get(part) or {}
    before, after = pair.get("before") or {}, pair.get("after") or {}
    lines = [
        f"{text}: {format_change(before[key], after.get(key), unit)}"
        for key, (text, unit) in METRICS.items()
        if before.get(key) is not None
    ]
    labels = [part.replace("_", " "), *[""] * len(lines)]
    return list(zip(labels, lines, strict=False))


def _effect(effect: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    """Return a row for each parameter and for the place; only the first one names the effect."""
    values = [(name, _value(value)) for name, value in (effect.get("parameters") or {}).items()]
    values += [("place", place)] if (place := _where(effect)) else []
    heads = [(effect_name(effect["effect"]), format_share(effect.get("probability")))]
    heads += [("", "")] * (len(values) - 1)
    return [(*head, *value) for head, value in zip(heads, values or [("", "")], strict=True)]


def _value(value: Any) -> str:
    found = format_parameter(value)
    if not found.is_identifiable:
        return NOT_IDENTIFIABLE
    if found.rows:
        return f"{len(found.rows)} \N{MULTIPLICATION SIGN} {len(found.rows)} matrix"
    return f"{found.mean} ± {found.sd}" if found.sd else f"{found.mean}{found.unit}"


def _where(effect: Mapping[str, Any]) -> str:
    where = effect.get("where") or {}
    for key, frame in (("body_point", "object"), ("world_point", "world")):
        if where.get(key):
            at, sd = (where[key].get(part) for part in ("mean", "sd"))
            spread = None if sd is None else np.asarray(sd, dtype=float)
            return f"{format_point(np.asarray(at, dtype=float), spread)}, {frame}"
    return ""


def posterior_card(summary: Mapping[str, Any]) -> Card:
    """Return the card of a posterior from its summary."""
    facts = [("chains", summary["verdict"])]
    if summary["lack_of_fit"] is not None:
        facts.append(("model", describe_lack_of_fit(summary["lack_of_fit"])))
    rows = [
        (*_parameter(parameter), format_number(parameter["r_hat"]), f"{parameter['ess_bulk']:.0f}")
        for parameter in summary["parameters"]
    ]
    title = f"trundle.Posterior of {summary['recording']!r}, {summary['method']}"
    return Card(title, facts, Table((*PARAMETER_HEADS, "R-hat", "ESS"), rows))
