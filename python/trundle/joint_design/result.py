"""The result of a design for a mechanism."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from trundle.atomic import write_text
from trundle.display import Card, Displayed, Table

if TYPE_CHECKING:
    from trundle.mechanism import MechanismModel
    from trundle.native_inputs import PathLike

__all__ = ["DesignedTrajectory", "JointDesign"]

Floats = NDArray[np.float64]

SHOWN_TRAJECTORIES = 5
"""Trajectories in the table of a card."""


@dataclass(frozen=True, repr=False)
class DesignedTrajectory(Displayed):
    """A trajectory of all joints on a rig.

    Attributes
    ----------
    profile : str
        "ramps", "ramps_at_several_speeds", "sine", "slow_approaches" or "all_joints".
    joint : str or None
        The joint that moves; None for all.
    change : str or None
        The change of the rig; None for the rig as recorded.
    separation : tuple of two floats
        Expected log-likelihood ratio against the best refit of the other model, nats: if the first model is
        true, and if the second is.
    effort : dict of str to float
        Largest effort of each joint under either model.
    sentence : str
        Instruction in words.
    t : (T,) array
        Uniform times from 0, s.
    q, v : (T, n) array
        Positions and velocities of the recorded joints, rad or m, at rest at both ends.

    Examples
    --------
    >>> design = trundle.design(  # doctest: +SKIP
    ...     "joint_dry_friction:arm", "joint_viscous_friction:arm", recording="bench/"
    ... )
    >>> design.trajectories[0].profile  # doctest: +SKIP
    'ramps_at_several_speeds'
    """

    profile: str
    joint: str | None
    change: str | None
    separation: tuple[float, float]
    effort: dict[str, float]
    sentence: str
    t: Floats
    q: Floats
    v: Floats

    def _card(self) -> Card:
        first, second = self.separation
        efforts = ", ".join(f"{joint} {effort:.3g}" for joint, effort in self.effort.items())
        facts = [
            ("trajectory", self.sentence),
            ("separation", f"{first:.3g} nats if the first model is true, {second:.3g} if the second is"),
            ("largest effort", efforts),
            ("duration", f"{self.t[-1]:.3g} s"),
        ]
        return Card(f"trundle.joint_design.DesignedTrajectory: {self.profile}", facts)


@dataclass(frozen=True, repr=False)
class JointDesign(Displayed):
    """The trajectory, or the change of load, that best separates two explanations of a mechanism.

    Attributes
    ----------
    models : tuple of two str
        The effects that only this model has.
    trajectories : tuple of DesignedTrajectory
        Best first; the first one is on the recorded rig if that is enough. Empty if the drives cannot follow
        any within the limits.
    separation : tuple of two floats
        Of the first trajectory.
    threshold : float
        Separation, nats, at which a model reaches a probability of 0.95.
    rig_can_tell : bool
        Whether a trajectory on the recorded rig, within the limits, reaches the threshold.
    change : str or None
        The change of the rig that reaches the threshold where the recorded rig does not.
    recorded : float
        Log evidence of the recording for the first model over the second, nats.
    sure : float
        Probability that the true model has a posterior probability above 0.95 after the first trajectory.
    repeats : int or None
        Number of repetitions for which `sure` reaches 0.95; None if 50 are not enough.
    sentence : str
        Summary in words.
    fitted : tuple of two MechanismModel
        The models as fitted to the recording.
    warnings : tuple of str

    Examples
    --------
    >>> t = np.arange(0, 10, 0.01)
    >>> q, a = np.sin(2 * t) + 0.3 * np.sin(5.3 * t), -4 * np.sin(2 * t) - 8.427 * np.sin(5.3 * t)
    >>> v = 2 * np.cos(2 * t) + 1.59 * np.cos(5.3 * t)
    >>> columns = {"t": t, "q_arm": q, "effort_arm": 0.1 * a + 0.05 * v + 0.4 * np.sign(v)}
    >>> metadata = {"format": "trundle-recording/2", "name": "bench"}
    >>> metadata["mechanism"] = {"axis": "hinge", "joints": ["arm"]}
    >>> bench = trundle.JointRecording(metadata, {"one": columns})
    >>> trundle.design("joint_dry_friction:arm", "joint_cogging:arm", recording=bench).rig_can_tell
    True
    """

    models: tuple[str, str]
    trajectories: tuple[DesignedTrajectory, ...]
    separation: tuple[float, float]
    threshold: float
    rig_can_tell: bool
    change: str | None
    recorded: float
    sure: float
    repeats: int | None
    sentence: str
    fitted: tuple[MechanismModel, MechanismModel]
    warnings: tuple[str, ...]
    _answer: dict[str, Any]

    def to_json(self) -> str:
        """Return the content of ``design.json``."""
        return json.dumps(self._answer, indent=2, ensure_ascii=False, allow_nan=False)

    def trajectory_csv(self) -> str:
        """Return the first trajectory as a table with the columns ``t`` and ``q_JOINT``, or an empty text."""
        if not self.trajectories:
            return ""
        best = self.trajectories[0]
        names = ["t", *(f"q_{joint}" for joint in self.fitted[0].mechanism.joints)]
        rows = [",".join(f"{value:.9g}" for value in row) for row in np.column_stack([best.t, best.q])]
        return "\n".join([",".join(names), *rows, ""])

    def write(self, folder: PathLike) -> Path:
        """Write ``design.json``, and ``trajectory.csv`` if there is a trajectory."""
        folder = Path(folder)
        texts = {"design.json": self.to_json() + "\n"}
        if self.trajectories:
            texts["trajectory.csv"] = self.trajectory_csv()
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            write_text(folder / name, text)
        return folder

    def _card(self) -> Card:
        rows = [
            (
                one.profile,
                one.joint or "all",
                one.change or "as recorded",
                f"{one.separation[0]:.3g}",
                f"{one.separation[1]:.3g}",
            )
            for one in self.trajectories[:SHOWN_TRAJECTORIES]
        ]
        facts = [("models", " or ".join(self.models)), ("result", self.sentence)]
        heads = ("trajectory", "joint", "rig", "nats, first true", "nats, second true")
        return Card("trundle.JointDesign", facts, Table(heads, rows))
