"""What the diagnosis needs of the mechanism under test, for any simulator."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from trundle._native import JointRecording, _JointOutcome
from trundle._types import JointMotion

if TYPE_CHECKING:
    from trundle.mechanism.drives import Drive
    from trundle.mechanism.simulation import JointLaws

__all__ = ["COMPLIANT", "FittedMechanism", "MechanismUnderTest", "Report", "joint_kinds"]

Floats = NDArray[np.float64]
Report = Callable[[str, float], object]
COMPLIANT = ("joint_backlash", "joint_elasticity")
"""Effects with a drive that moves relative to its joint."""


class FittedMechanism(Protocol):
    """The mechanism of an episode with fitted values, and the effects that are no laws of joints.

    Attributes
    ----------
    can_simulate : bool
        Whether plays and elastic transmissions can be simulated, if there are some.
    """

    can_simulate: bool

    def needed(self, t: Floats, q: Floats, v: Floats, a: Floats) -> tuple[Floats, Floats]:
        """Return the effort for a motion, and the diagonal of the mass matrix, (T, n) each."""
        ...

    def simulate(
        self, t: Floats, q: Floats, v: Floats, drive: Drive, laws: JointLaws | None, known: Drive | None
    ) -> Floats:
        """Return positions, (T, n), in open loop from a state; NaN after a divergence."""
        ...


class MechanismUnderTest(Protocol):
    """The mechanisms of a recording's episodes."""

    warnings: list[str]

    @property
    def joint_kinds(self) -> list[str]:
        """The kind of each recorded joint: "hinge" or "slide"."""
        ...

    @property
    def is_model_file(self) -> bool:
        """Whether it is an MJCF or URDF file."""
        ...

    def dynamics(self, motion: JointMotion, report: Report) -> dict[str, Any]:
        """Return what the native module needs of the mechanism along the recorded motion."""
        ...

    def expand_again(self, motion: JointMotion, outcome: _JointOutcome) -> bool:
        """Choose fitted values for the next evaluation; False if the present one is accurate there."""
        ...

    def fitted(self, episode: str, model: Mapping[str, Any]) -> FittedMechanism:
        """Return the mechanism of an episode with the values of a fitted model."""
        ...

    def joint_before(self, body: str) -> str:
        """Return the last recorded joint before a body."""
        ...


def joint_kinds(recording: JointRecording, mechanisms: MechanismUnderTest | None) -> dict[str, str]:
    """Return the kind of each joint, "hinge" or "slide"; `mechanisms` is None for an axis without a model."""
    if mechanisms is None:
        return {joint: recording.metadata["mechanism"]["axis"] for joint in recording.joints}
    return dict(zip(recording.joints, mechanisms.joint_kinds, strict=True))
