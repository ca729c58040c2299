"""The search for the trajectory, or the change of load, that separates two explanations of a mechanism."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from trundle import _native
from trundle._native import JointRecording, TrundleError, _JointDesigner
from trundle.joint_design.explanations import Explanation, name_explanations, parse_explanation
from trundle.joint_design.limits import GivenLimits, JointLimits, parse_limits
from trundle.joint_design.result import DesignedTrajectory, JointDesign
from trundle.joint_design.rigs import AxisLoad, changed_rigs, covariate_rigs, given_rigs
from trundle.joint_design.separation import Candidate, Evaluator
from trundle.joint_design.trajectories import Trajectory, trajectories
from trundle.joint_design.words import instruction, summary
from trundle.joint_diagnosis.mechanisms import load_mechanisms
from trundle.joint_diagnosis.model_file import TABLE_KEYS
from trundle.mechanism.files import JointEffect, MechanismModel, MechanismTable
from trundle.mechanism.loading import Payload
from trundle.progress import ProgressOption, report_progress

if TYPE_CHECKING:
    from trundle.native_inputs import PathLike

__all__ = ["design_joints"]

Floats = NDArray[np.float64]

MAX_DURATION_S = 20.0
"""Longest default duration."""
MIN_DURATION_S = 2.0
MAX_TRAJECTORIES = 10
"""Trajectories of a result."""
MAX_ON_CHANGED_RIG = 16
"""Trajectories of a mechanism with a model that are tried on a changed rig."""
POSE_QUANTILES = (0.02, 0.5, 0.98)
"""Quantiles of a joint's effort, at which the recorded poses of the other joints are taken."""
MAX_JOINTS_WITH_POSES = 2
"""Number of moving joints up to which several poses of the other joints are tried."""
FIT_SHARE = 0.4
"""Share of the work that is the fit of both models."""


def design_joints(
    first: Explanation,
    second: Explanation,
    recording: JointRecording,
    mjcf: PathLike | None = None,
    *,
    limits: GivenLimits | None = None,
    duration: float | None = None,
    loads: Sequence[AxisLoad | Payload] = (),
    progress: ProgressOption = None,
) -> JointDesign:
    """Find the trajectory, or the change of load, that separates two explanations; see `trundle.design`."""
    if duration is not None and not duration > 0:
        raise TrundleError(f"duration = {duration}: must be positive")
    effects = (parse_explanation(first, recording), parse_explanation(second, recording))
    with report_progress(progress, "design") as option:
        report = option or (lambda stage, share: None)
        motion = _native._joint_motion(recording)
        has_model = mjcf is not None or "model" in recording.metadata["mechanism"]
        mechanisms = load_mechanisms(recording, motion, mjcf) if has_model else None
        dynamics = None if mechanisms is None else mechanisms.dynamics(motion, lambda _stage, _share: None)
        designer = _native._joint_designer(
            recording, dynamics, *effects, progress=lambda stage, share: report(stage, FIT_SHARE * share)
        )
        own = parse_limits(designer.limits, limits or GivenLimits())
        evaluator = Evaluator(recording, designer, mechanisms, mjcf, own)
        search = _Search(evaluator, _candidates(designer, own, motion, dynamics, recording, duration))
        given = given_rigs(loads, has_model=has_model)
        search.run(given, lambda share: report("trajectories", FIT_SHARE + (1 - FIT_SHARE) * share))
    warnings = [] if mechanisms is None else list(mechanisms.warnings)
    return _result(recording, mjcf, search, warnings)


def _candidates(
    designer: _JointDesigner,
    limits: Sequence[JointLimits],
    motion: Any,
    dynamics: Any,
    recording: JointRecording,
    duration: float | None,
) -> list[Trajectory]:
    training = [name for name, episode in recording.items() if not episode.held_out]
    spans = [float(np.ptp(motion["episodes"][name]["t"])) for name in training]
    duration = duration or float(np.clip(max(spans), MIN_DURATION_S, MAX_DURATION_S))
    names = [name for own in designer.names for name in own]
    concerned = [joint for joint in recording.joints if any(name.endswith(f":{joint}") for name in names)]
    if any(name.partition(":")[2] not in recording.joints for name in names):
        concerned = recording.joints
    moving = [recording.joints.index(joint) for joint in concerned]
    positions = np.concatenate([motion["episodes"][name]["q"] for name in training])
    quantiles = POSE_QUANTILES if len(moving) <= MAX_JOINTS_WITH_POSES else (0.5,)
    low, high = (np.array([getattr(one, key) for one in limits]) for key in ("low", "high"))
    poses = []
    for j in moving:
        if dynamics is None or len(recording.joints) == 1:
            poses.append([np.zeros(len(recording.joints))])
            continue
        effort = np.concatenate([dynamics["episodes"][name]["effort"][:, j] for name in training])
        rows = {int(np.argmin(np.abs(effort - np.quantile(effort, each)))) for each in quantiles}
        poses.append([np.clip(positions[row], low, high) for row in sorted(rows)])
    return trajectories(limits, moving, poses, duration, designer.dt)


class _Search:
    """Evaluates trajectories on the recorded rig, and on others where that cannot tell."""

    def __init__(self, evaluator: Evaluator, candidates: list[Trajectory]) -> None:
        self.evaluator, self.candidates = evaluator, candidates
        self.as_recorded: list[Candidate] = []
        self.changed: list[Candidate] = []
        self.tried: list[str] = []

    def run(self, given: Sequence[Any], report: Any) -> None:
        """Evaluate all candidates; `given` are rigs that the user asked for."""
        own = self.evaluator
        recorded = covariate_rigs(own.recording)
        for k, rig in enumerate(recorded):
            self.as_recorded += self._evaluated(rig, self.candidates, report, k / len(recorded) / 2)
        self.as_recorded.sort(key=lambda one: -one.value)
        rigs = list(given)
        if not rigs and not self.reaches(self.as_recorded):
            names = [name for names in own.designer.names for name in names]
            rigs = changed_rigs(own.recording, own.mechanisms, names, own.limits[0].effort)
            if any(name == "base_tilt" for name in names):
                rigs = [rig for rig in rigs if rig.tilt is None]
        some = self.candidates
        if own.mechanisms is not None:
            ranked = [one.trajectory for one in self.as_recorded] or self.candidates
            some = ranked[:MAX_ON_CHANGED_RIG]
        for k, rig in enumerate(rigs):
            self.tried.append(rig.words)
            self.changed += self._evaluated(rig, some, report, 0.5 + k / len(rigs) / 2)
        self.changed.sort(key=lambda one: -one.value)

    def _evaluated(self, rig: Any, some: Sequence[Trajectory], report: Any, share: float) -> list[Candidate]:
        report(share)
        found = [self.evaluator.evaluate(trajectory, rig) for trajectory in some]
        return [one for one in found if one is not None]

    def reaches(self, candidates: Sequence[Candidate]) -> bool:
        """Whether the best of sorted candidates reaches the threshold."""
        return bool(candidates) and candidates[0].value >= self.evaluator.designer.decisive_nats

    @property
    def best(self) -> Candidate | None:
        """The candidate that reaches the threshold, on the recorded rig if possible."""
        for candidates in (self.as_recorded, self.changed):
            if self.reaches(candidates):
                return candidates[0]
        return None


def _result(
    recording: JointRecording, mjcf: PathLike | None, search: _Search, warnings: list[str]
) -> JointDesign:
    designer, joints = search.evaluator.designer, recording.joints
    models = name_explanations(*designer.names)
    best, rig_can_tell = search.best, search.reaches(search.as_recorded)
    ranked = [*search.as_recorded, *search.changed]
    ranked.sort(key=lambda one: (one is not best, -one.value))
    shown = [_trajectory(one, joints) for one in ranked[:MAX_TRAJECTORIES]]
    separation = ranked[0].separation if ranked else (0.0, 0.0)
    sure, repeats = designer.success(separation)
    repeats = repeats if ranked else None
    first = search.as_recorded[0] if search.as_recorded else None
    sentence = summary(
        models, best, first, search.tried, designer.advice, designer.decisive_nats, sure, repeats
    )
    if designer.is_unexplained:
        warnings.append(
            "neither model explains the recording, but the design assumes that one of them is true: run "
            "`trundle diagnose` on the recording first"
        )
    if not ranked:
        warnings.append(
            f"the drives can follow none of the {search.evaluator.rejected} trajectories within the limits "
            "of effort: raise `effort`, or lower `speed` and `acceleration`"
        )
    change = best.rig.words if best is not None and not rig_can_tell else None
    answer = {
        "format": "trundle-joint-design/1",
        "recording": recording.name,
        "models": list(models),
        "separation": list(separation),
        "threshold": designer.decisive_nats,
        "rig_can_tell": rig_can_tell,
        "change": change,
        "recorded": designer.recorded,
        "sure": sure,
        "repeats": repeats,
        "sentence": sentence,
        "trajectories": [_entry(one) for one in shown],
        "changes_tried": search.tried,
        "limits": [_limit(one) for one in search.evaluator.limits],
        "noise": dict(zip(joints, designer.noise, strict=True)),
        "effort_unit": dict(zip(joints, designer.effort_units, strict=True)),
        "warnings": warnings,
    }
    fitted = _fitted(recording, mjcf, designer)
    return JointDesign(
        models,
        tuple(shown),
        separation,
        designer.decisive_nats,
        rig_can_tell,
        change,
        designer.recorded,
        sure,
        repeats,
        sentence,
        fitted,
        tuple(warnings),
        answer,
    )


def _trajectory(one: Candidate, joints: Sequence[str]) -> DesignedTrajectory:
    own = one.trajectory
    return DesignedTrajectory(
        own.profile,
        own.joint,
        one.rig.words or None,
        one.separation,
        dict(zip(joints, one.effort, strict=True)),
        instruction(one),
        own.t,
        own.q,
        own.v,
    )


def _entry(one: DesignedTrajectory) -> dict[str, Any]:
    keys = ("profile", "joint", "change", "effort", "sentence")
    own = {key: getattr(one, key) for key in keys}
    return own | {"separation": list(one.separation), "duration": float(one.t[-1])}


def _limit(limit: JointLimits) -> dict[str, Any]:
    return {
        "joint": limit.joint,
        "position": [limit.low, limit.high],
        "speed": limit.speed,
        "acceleration": limit.acceleration,
        "effort": limit.effort,
    }


def _fitted(
    recording: JointRecording, mjcf: PathLike | None, designer: _JointDesigner
) -> tuple[MechanismModel, MechanismModel]:
    table = {key: value for key, value in recording.metadata["mechanism"].items() if key in TABLE_KEYS}
    if mjcf is not None:
        table["model"] = str(mjcf)
    first, second = (
        MechanismModel(
            MechanismTable(**table),
            dict(model["nominal"]),
            [
                JointEffect(one["kind"], one.get("joint"), one.get("body"), dict(one["values"]))
                for one in model["effects"]
            ],
        )
        for model in designer.models
    )
    return first, second
