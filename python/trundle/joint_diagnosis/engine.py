"""The diagnosis of a recording of joints."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from trundle import _native
from trundle._native import JointRecording, TrundleError
from trundle._types import JointAnswer, JointMotion
from trundle.black_box import Parameters, parse_parameters
from trundle.input_checks import require_usable
from trundle.joint_diagnosis.held_out import (
    Path,
    axis_paths,
    fill_position_figures,
    mechanism_paths,
    position_spans,
)
from trundle.joint_diagnosis.log import import_command, is_log, undriven_warnings
from trundle.joint_diagnosis.mechanisms import load_mechanisms
from trundle.joint_diagnosis.model_file import build_model
from trundle.joint_diagnosis.result import JointDiagnosis
from trundle.joint_diagnosis.simulators import SimulatorUnderTest
from trundle.joint_diagnosis.under_test import MechanismUnderTest, Report, joint_kinds
from trundle.joint_simulator import JointSimulator, JointStep
from trundle.progress import ProgressOption, report_progress
from trundle.report import inputs

__all__ = ["diagnose_joints"]

DYNAMICS_SHARE = 0.3
"""Share of the work that is the evaluation of the model."""
SEARCH_SHARE = 0.9
"""Share of the work that is done when the figures of positions begin."""
HELD_OUT_METRICS = (
    ("position_rmse", "position error in open loop"),
    ("window_position_rmse", "position error one second ahead"),
    ("effort_rmse", "effort error"),
)
"""Errors of a joint in held-out episodes: key, text."""


def diagnose_joints(
    recording: JointRecording,
    mjcf: str | os.PathLike[str] | None = None,
    *,
    step: JointStep | None = None,
    parameters: Parameters | None = None,
    vectorized: bool = False,
    without: Sequence[str] = (),
    check: bool = True,
    progress: ProgressOption = None,
    command: str | None = None,
    source: str | os.PathLike[str] | None = None,
    advise: Callable[[JointAnswer, JointRecording], None] | None = None,
) -> JointDiagnosis:
    """Diagnose a recording of joints; `trundle.diagnose` describes the arguments.

    `source` is the path of the recording, for the report; `advise` changes experiments of alternatives.
    """
    warnings = _input_warnings(recording, source, mjcf, check=check)
    with report_progress(progress, "diagnose") as option:
        report = option or (lambda stage, share: None)
        motion = _native._joint_motion(recording)
        under_test: MechanismUnderTest | None
        if step is None:
            under_test = _model_under_test(recording, motion, mjcf, report)
        else:
            described, is_given = ([], False) if parameters is None else parse_parameters(parameters)
            simulator = JointSimulator(step, motion["joints"], vectorized=vectorized)
            under_test = SimulatorUnderTest(recording, simulator, described, is_given=is_given)
        outcome = _search(recording, motion, under_test, without, report)
        answer = outcome.answer
        paths = _predictions(recording, motion, under_test, outcome, answer)
        own = under_test.warnings if under_test else []
        kinds = joint_kinds(recording, under_test)
        unseen = outcome.held_out_warnings(_held_out_metrics(answer, kinds, position_spans(recording)))
        answer["warnings"] = [*warnings, *own, *answer["warnings"], *unseen]
        if not answer["missing"]:
            answer["residual"]["explained"] = None
        if advise is not None:
            advise(answer, recording)
        report("report", 1.0)
    from trundle.joint_diagnosis.report import render_joints  # takes long to import

    model = build_model(_table(recording, mjcf, under_test, step), outcome.models[1], answer)
    by_hand = f"trundle diagnose {recording.name if source is None else os.fspath(source)}"
    command = command or (by_hand if step is None else "trundle.diagnose(..., step=...)")
    fingerprints = inputs(recording=source, mjcf=mjcf)
    page = render_joints(answer, recording, motion, outcome, under_test, paths, command, fingerprints)
    return JointDiagnosis(answer, model, page, paths, recording)


def _input_warnings(
    recording: JointRecording,
    source: str | os.PathLike[str] | None,
    mjcf: str | os.PathLike[str] | None,
    *,
    check: bool,
) -> list[str]:
    """Return doubts about a recording, or about the CSV log that it was read from; refuse mistakes."""
    if source is None or not is_log(source):
        return require_usable(recording) if check else []
    try:
        return [*undriven_warnings(recording), *(require_usable(recording) if check else [])]
    except TrundleError as error:
        if "[effort]" not in str(error):
            raise
        gain, signed = f"recording.effort.gain.{recording.joints[0]}=-1.0", "recording.effort.signed=false"
        raise TrundleError(
            f"{error}; a CSV log has no [effort] table: change the column, or write a recording with "
            f"`{import_command(source, mjcf)}` and keys such as `--set {gain}` or `--set {signed}`, and "
            "diagnose its folder"
        ) from None


def _held_out_metrics(
    answer: JointAnswer, kinds: Mapping[str, str], spans: Mapping[str, float]
) -> list[tuple[str, str, float | None, float | None]]:
    """Return the errors of each joint in held-out episodes: name, unit, before and after.

    An error in open loop beyond the joint's range of positions, `spans`, is left out: the simulation has lost
    the recorded motion, and a larger error says no more than a smaller one.
    """
    pair = answer["fit"]["held_out"]
    if not pair:
        return []
    found = []
    for joint, before in pair["before"]["joints"].items():
        after = pair["after"]["joints"][joint]
        position = "rad" if kinds[joint] == "hinge" else "m"
        effort = answer["residual"]["effort_unit"][joint]
        for (key, text), unit in zip(HELD_OUT_METRICS, (position, position, effort), strict=True):
            if key == "position_rmse" and (before[key] or 0.0) > spans[joint]:
                continue
            found.append((f"{text} of joint {joint}", unit, before[key], after[key]))
    return found


def _model_under_test(
    recording: JointRecording,
    motion: JointMotion,
    mjcf: str | os.PathLike[str] | None,
    report: Report,
) -> MechanismUnderTest | None:
    """Return the model of a recording, or None for an axis without one."""
    table = recording.metadata["mechanism"]
    if mjcf is not None and "axis" in table:
        raise TrundleError(
            f"{recording.name}: [mechanism] has an axis without a model; replace `axis` by "
            'model = "robot.xml", or remove the MJCF file'
        )
    if mjcf is None and "model" not in table:
        return None
    report("mechanism", 0.0)
    return load_mechanisms(recording, motion, mjcf)


def _search(
    recording: JointRecording,
    motion: JointMotion,
    under_test: MechanismUnderTest | None,
    without: Sequence[str],
    report: Report,
) -> _native._JointOutcome:
    """Search for missing effects, again if efforts are not linear in the parameters of a simulator."""
    start = DYNAMICS_SHARE if under_test else 0.0
    done = 0.0

    def forward(stage: str, share: float) -> None:
        nonlocal done
        done = max(done, share)
        report(stage, done)

    while True:
        dynamics = None
        if under_test is not None:
            dynamics = under_test.dynamics(
                motion, lambda stage, share: forward(stage, DYNAMICS_SHARE * share)
            )
        outcome = _native._diagnose_joints(
            recording,
            dynamics,
            without=list(without),
            progress=lambda stage, share: forward(stage, start + (SEARCH_SHARE - start) * share),
        )
        if under_test is None or not under_test.expand_again(motion, outcome):
            return outcome


def _table(
    recording: JointRecording,
    mjcf: str | os.PathLike[str] | None,
    under_test: MechanismUnderTest | None,
    step: JointStep | None,
) -> dict[str, Any]:
    """Return the table `[mechanism]` of the fitted model."""
    if step is not None and under_test is not None:
        types = dict(zip(recording.joints, under_test.joint_kinds, strict=True))
        return {"joints": recording.joints, "types": types}
    table = dict(recording.metadata["mechanism"])
    if mjcf is not None:
        table.pop("types", None)
        table["model"] = os.path.basename(os.fspath(mjcf))
    return table


def _predictions(
    recording: JointRecording,
    motion: JointMotion,
    under_test: MechanismUnderTest | None,
    outcome: _native._JointOutcome,
    answer: JointAnswer,
) -> dict[str, Path]:
    """Return the open-loop simulations of the held-out episodes; add their figures to the answer."""
    if under_test is None:
        return axis_paths(outcome.predictions)
    paths = mechanism_paths(recording, motion, under_test, outcome)
    fill_position_figures(answer, recording, paths)
    return paths
