"""The report of a diagnosis of joints: one HTML page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from trundle import _native
from trundle._native import JointRecording, _JointOutcome
from trundle._types import JointAnswer, JointMotion
from trundle.joint_diagnosis.figures import chain_figure, law_figures, time_figure
from trundle.joint_diagnosis.held_out import Path, largest_commands
from trundle.joint_diagnosis.residuals import joint_efforts
from trundle.joint_diagnosis.symptoms import headline, name_of_effect, residual_sentence, symptoms
from trundle.joint_diagnosis.under_test import MechanismUnderTest, joint_kinds
from trundle.report.figures.canvas import Figure
from trundle.report.jinja import render_template
from trundle.report.parameter import format_parameter
from trundle.report.quantity import format_significant, join_words
from trundle.report.wording import capitalise, explained_by_effect, format_percent, format_share

__all__ = ["render_joints"]

MAX_JOINTS = 3
"""Joints with figures."""
MAX_EPISODES = 3
"""Held-out episodes with figures."""
FIGURE_NAMES = {
    "position_rmse": "position, open loop",
    "window_position_rmse": "position, one second ahead",
    "effort_rmse": "required less recorded effort",
}
"""Figures of a joint: key, text."""
POOLED_NAMES = {
    "relative_position_rmse": "position, open loop, share of the range",
    "relative_window_rmse": "position, one second ahead, share of the range",
    "relative_effort_rmse": "required less recorded effort, share of the range",
}
"""Figures of all joints: key, text."""


def render_joints(
    answer: JointAnswer,
    recording: JointRecording,
    motion: JointMotion,
    outcome: _JointOutcome,
    mechanisms: MechanismUnderTest | None,
    paths: Mapping[str, Path],
    command: str,
    fingerprints: list[dict[str, str]],
) -> str:
    """Render the page; the same input gives the same bytes."""
    kinds = joint_kinds(recording, mechanisms)
    marked = _concerned(answer, mechanisms)
    if answer["verdict"] == "unexplained":
        marked = _worst(answer)[:1]
    shown = (marked or _worst(answer))[:MAX_JOINTS]
    laws, episodes = _figures(answer, recording, motion, outcome, mechanisms, paths, kinds, shown)
    return render_template(
        "trundle.report",
        "joints.html",
        title=f"{answer['recording']}: {headline(answer)}",
        recording=answer["recording"],
        headline=headline(answer),
        verdict=answer["verdict"],
        warnings=answer["warnings"],
        chain=chain_figure(motion["joints"], marked, [kinds[joint] for joint in motion["joints"]]),
        missing=[_effect(one) for one in answer["missing"]],
        immaterial=[_effect(one) for one in answer["immaterial"]],
        shares=_shares(answer),
        regime=answer["mismatch"].get("regime"),
        symptoms=symptoms(answer),
        remains=residual_sentence(answer),
        laws=laws,
        episodes=episodes,
        tied=[join_words(names, "or") for names in answer["tied"]],
        alternatives=[
            (name_of_effect(one), format_share(one["probability"]), one["experiment"])
            for one in answer["alternatives"]
        ],
        figures={part: _metrics(answer, part) for part in ("held_out", "training")},
        nominal=_nominal(answer),
        command=command,
        version=_native.__version__,
        fingerprints=fingerprints,
        use=_use(answer, is_model_file=mechanisms is not None and mechanisms.is_model_file),
    )


def _effect(entry: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "name": capitalise(name_of_effect(entry)),
        "kind": entry["effect"],
        "statement": entry["statement"],
        "probability": format_share(entry["probability"]),
        "explains": explained_by_effect(entry["explains"]),
        "parameters": [
            (name.replace("_", " "), [format_parameter(value)]) for name, value in entry["parameters"].items()
        ],
    }


def _concerned(answer: JointAnswer, mechanisms: MechanismUnderTest | None) -> list[str]:
    """Return the joints of the missing effects; for a body, the last joint before it."""
    found = []
    for one in answer["missing"]:
        where = one["where"] or {}
        if "joint" in where:
            found.append(where["joint"])
        elif "body" in where and mechanisms is not None:
            found.append(mechanisms.joint_before(where["body"]))
    return list(dict.fromkeys(found))


def _worst(answer: JointAnswer) -> list[str]:
    """Return the joint with the largest share of the misfit."""
    shares = answer["mismatch"]["joints"]
    return [max(shares, key=lambda joint: float(shares[joint]))] if shares else []


def _units(answer: JointAnswer, joint: str, kind: str) -> tuple[str, str]:
    """Return the units of position and effort of a joint."""
    return "rad" if kind == "hinge" else "m", answer["residual"]["effort_unit"][joint]


def _figures(
    answer: JointAnswer,
    recording: JointRecording,
    motion: JointMotion,
    outcome: _JointOutcome,
    mechanisms: MechanismUnderTest | None,
    paths: Mapping[str, Path],
    kinds: Mapping[str, str],
    shown: list[str],
) -> tuple[list[Figure], list[Figure]]:
    """Return the figures of laws, and those of held-out episodes."""
    largest = largest_commands(recording, motion)
    efforts = {
        name: joint_efforts(recording, name, motion, outcome, mechanisms, largest)
        for name in motion["episodes"]
    }
    training = [name for name, one in recording.items() if not one.held_out]
    held_out = [name for name, one in recording.items() if one.held_out][:MAX_EPISODES]
    laws, episodes = [], []
    for joint in shown:
        k, units = motion["joints"].index(joint), _units(answer, joint, kinds[joint])
        usable = [efforts[name][k] for name in training if len(efforts[name][k].t) > 1]
        if usable:
            laws += law_figures(joint, usable, units)
        for name in held_out:
            if len(efforts[name][k].t) > 1:
                episodes.append(time_figure(name, joint, k, efforts[name][k], paths.get(name), units))
    return laws, episodes


def _shares(answer: JointAnswer) -> list[tuple[str, str, str]]:
    """Return each joint with its share of the misfit and the residual effort."""
    shares, residual = answer["mismatch"]["joints"], answer["residual"]
    rest = {
        joint: f"{format_significant(rms)} {residual['effort_unit'][joint]}"
        for joint, rms in residual["effort_rms"].items()
    }
    return [
        (joint, format_percent(share), rest.get(joint, "–"))
        for joint, share in sorted(shares.items(), key=lambda item: -item[1])
    ]


def _metrics(answer: JointAnswer, part: str) -> list[tuple[str, str, str]]:
    pair = answer["fit"][part]
    if not pair:
        return []
    sides = [pair[side] for side in ("before", "after")]
    before, after = sides
    rows = [(text, _number(before[key]), _number(after[key])) for key, text in POOLED_NAMES.items()]
    for joint in before["joints"]:
        first, second = (side["joints"][joint] for side in sides)
        rows += [
            (f"{joint}: {text}", _number(first[key]), _number(second[key]))
            for key, text in FIGURE_NAMES.items()
        ]
    return [row for row in rows if row[1:] != ("–", "–")]


def _number(value: float | None) -> str:
    return "–" if value is None or not np.isfinite(value) else format_significant(value)


def _nominal(answer: JointAnswer) -> list[tuple[str, list[Any]]]:
    nominal = answer["nominal"]
    rows = []
    for name, after in nominal["after"].items():
        given = nominal["given"].get(name)
        shown = {"mean": given, "sd": None, "unit": after["unit"]} if given is not None else None
        cells = [shown, nominal["before"].get(name), after]
        rows.append((name, [format_parameter(cell if cell else {"identifiable": False}) for cell in cells]))
    return rows


def _use(answer: JointAnswer, *, is_model_file: bool) -> dict[str, Any] | None:
    """Return the box of ready-made code; None if something without a name is missing."""
    if answer["verdict"] == "unexplained":
        return None
    source = "\n".join(
        [
            "from trundle.mechanism import MechanismModel",
            "",
            'model = MechanismModel.read("model.toml")',
            "print(model.nominal, [effect.name for effect in model.effect])",
        ]
    )
    snippets = [{"name": "Python", "code": source, "is_open": True}]
    if is_model_file:
        line = "trundle export model.toml --mjcf-patch patched --mjcf robot.xml"
        snippets.insert(0, {"name": "Patch the MJCF", "code": line, "is_open": True})
        snippets[1]["is_open"] = False
    content = "model.toml contains the refitted values and the missing effects."
    return {"title": "Use the model", "content": content, "snippets": snippets}
