"""The diagnosis of a recording of joints."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

from trundle import _native
from trundle._native import JointRecording, TrundleError
from trundle._types import JointAnswer
from trundle.input_checks import require_usable
from trundle.joint_diagnosis.held_out import Path, axis_paths, fill_position_figures, mechanism_paths
from trundle.joint_diagnosis.mechanisms import EpisodeMechanisms, dynamics_of, load_mechanisms
from trundle.joint_diagnosis.model_file import build_model
from trundle.joint_diagnosis.result import JointDiagnosis
from trundle.progress import ProgressOption, report_progress
from trundle.report import inputs

__all__ = ["diagnose_joints"]

DYNAMICS_SHARE = 0.3
"""Share of the work that is the evaluation of the model."""
SEARCH_SHARE = 0.9
"""Share of the work that is done when the figures of positions begin."""


def diagnose_joints(
    recording: JointRecording,
    mjcf: str | os.PathLike[str] | None = None,
    *,
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
    warnings = require_usable(recording) if check else []
    with report_progress(progress, "diagnose") as option:
        report = option or (lambda stage, share: None)
        motion = _native._joint_motion(recording)
        mechanisms = None
        has_model = mjcf is not None or "model" in recording.metadata["mechanism"]
        if mjcf is not None and "axis" in recording.metadata["mechanism"]:
            raise TrundleError(
                f"{recording.name}: [mechanism] has an axis without a model; replace `axis` by "
                'model = "robot.xml", or remove the MJCF file'
            )
        if has_model:
            report("mechanism", 0.0)
            mechanisms = load_mechanisms(recording, motion, mjcf)
        dynamics = None if mechanisms is None else dynamics_of(mechanisms, motion)
        start = DYNAMICS_SHARE if dynamics else 0.0
        outcome = _native._diagnose_joints(
            recording,
            dynamics,
            without=list(without),
            progress=lambda stage, share: report(stage, start + (SEARCH_SHARE - start) * share),
        )
        answer = outcome.answer
        paths = _predictions(recording, motion, mechanisms, outcome, answer)
        own = mechanisms.warnings if mechanisms else []
        answer["warnings"] = [*warnings, *own, *answer["warnings"]]
        if advise is not None:
            advise(answer, recording)
        report("report", 1.0)
    from trundle.joint_diagnosis.report import render_joints  # takes long to import

    table = dict(recording.metadata["mechanism"])
    if mjcf is not None:
        table["model"] = os.path.basename(os.fspath(mjcf))
    model = build_model(table, outcome.models[1], answer)
    command = command or f"trundle diagnose {recording.name if source is None else os.fspath(source)}"
    fingerprints = inputs(recording=source, mjcf=mjcf)
    page = render_joints(answer, recording, motion, outcome, mechanisms, paths, command, fingerprints)
    return JointDiagnosis(answer, model, page, paths)


def _predictions(
    recording: JointRecording,
    motion: Any,
    mechanisms: EpisodeMechanisms | None,
    outcome: _native._JointOutcome,
    answer: JointAnswer,
) -> dict[str, Path]:
    """Return the open-loop simulations of the held-out episodes; add their figures to the answer."""
    if mechanisms is None:
        return axis_paths(outcome.predictions)
    paths = mechanism_paths(recording, motion, mechanisms, outcome)
    fill_position_figures(answer, recording, paths)
    return paths
