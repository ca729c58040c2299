"""Separation of two explanations by trajectories on rigs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from trundle._native import JointRecording, _JointDesigner
from trundle.joint_design.limits import JointLimits
from trundle.joint_design.rigs import Rig
from trundle.joint_design.trajectories import Trajectory
from trundle.joint_diagnosis.fitted import tilt
from trundle.joint_diagnosis.mechanisms import EpisodeMechanisms, load_with_payload, motion_dynamics

if TYPE_CHECKING:
    from trundle.mechanism import Mechanism
    from trundle.native_inputs import PathLike

__all__ = ["Candidate", "Evaluator"]

Floats = NDArray[np.float64]

EFFORT_TOLERANCE = 1.001
"""Efforts may exceed a limit by rounding."""


@dataclass(frozen=True)
class Candidate:
    """A trajectory on a rig with its separation.

    Attributes
    ----------
    trajectory : Trajectory
    rig : Rig
    separation : tuple of two floats
        Expected log-likelihood ratio, nats: if the first model is true, and if the second is.
    value : float
        The separation by which candidates are ranked.
    effort : list of float
        Largest effort of each joint under either model.
    """

    trajectory: Trajectory
    rig: Rig
    separation: tuple[float, float]
    value: float
    effort: list[float]


@dataclass
class Evaluator:
    """Evaluates candidates for a recording.

    Attributes
    ----------
    recording : JointRecording
    designer : _JointDesigner
    mechanisms : EpisodeMechanisms or None
    mjcf : path or None
    limits : sequence of JointLimits
    rejected : int
        Number of candidates that no drive within the limits can follow.
    """

    recording: JointRecording
    designer: _JointDesigner
    mechanisms: EpisodeMechanisms | None
    mjcf: PathLike | None
    limits: Sequence[JointLimits]
    rejected: int = 0
    _variants: dict[str, Mechanism] = field(default_factory=dict)
    _dynamics: dict[tuple[int, str], Any] = field(default_factory=dict)

    @property
    def is_nested(self) -> bool:
        """Whether one explanation has all effects of the other."""
        first, second = map(set, self.designer.names)
        return first <= second or second <= first

    def evaluate(self, trajectory: Trajectory, rig: Rig) -> Candidate | None:
        """Return a candidate with its separation; None if a drive within the limits cannot follow it."""
        covariates = [rig.covariates.get(joint) for joint in self.recording.joints]
        found = self.designer.separation(
            trajectory.q,
            trajectory.v,
            trajectory.a,
            dynamics=self._dynamics_of(trajectory, rig),
            load=rig.load,
            covariates=covariates,
            other_encoder=rig.other_encoder,
        )
        first, second = found["nats"]
        if first is None or second is None or not self._is_within(found["effort"], rig):
            self.rejected += 1
            return None
        value = max(first, second) if self.is_nested else min(first, second)
        return Candidate(trajectory, rig, (first, second), value, found["effort"])

    def _is_within(self, efforts: Sequence[float], rig: Rig) -> bool:
        return all(
            effort <= EFFORT_TOLERANCE * limit.effort or (rig.adds_load and not limit.is_effort_given)
            for effort, limit in zip(efforts, self.limits, strict=True)
        )

    def _dynamics_of(self, trajectory: Trajectory, rig: Rig) -> Mapping[str, Floats] | None:
        if self.mechanisms is None:
            return None
        key = (id(trajectory), rig.words if rig.needs_model else "")
        if key not in self._dynamics:
            mechanism = self._mechanism(rig, self.mechanisms)
            motion = {"q": trajectory.q, "v": trajectory.v, "a": trajectory.a}
            has_offset = any("encoder_offset" in name for names in self.designer.names for name in names)
            self._dynamics[key] = motion_dynamics(mechanism, motion, derivatives=has_offset)
        return self._dynamics[key]  # type: ignore[no-any-return]

    def _mechanism(self, rig: Rig, mechanisms: EpisodeMechanisms) -> Mechanism:
        if not rig.needs_model:
            return mechanisms.first
        if rig.words not in self._variants:
            if rig.payload is not None:
                contacts = not mechanisms.warnings
                found = load_with_payload(self.recording, self.mjcf, rig.payload, contacts=contacts)
            else:
                found = mechanisms.first.adjusted()
                tilt(found.compiled, *(rig.tilt or (0.0, 0.0)))
            self._variants[rig.words] = found
        return self._variants[rig.words]
