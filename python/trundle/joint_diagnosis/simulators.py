"""The user's own simulator of joints as the mechanism under test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from trundle._native import JointRecording, TrundleError, _JointOutcome
from trundle._types import JointMotion
from trundle.joint_diagnosis.mechanisms import model_joint_kinds
from trundle.joint_diagnosis.under_test import COMPLIANT, Report
from trundle.joint_simulator import (
    EffortScale,
    InverseDynamics,
    JointSimulator,
    Samples,
    by_parameter,
    by_position,
    effort_scale,
    inverse_dynamics,
    simulate,
)

if TYPE_CHECKING:
    from trundle.mechanism.drives import Drive
    from trundle.mechanism.simulation import JointLaws

__all__ = ["FittedSimulator", "SimulatorUnderTest", "joint_types"]

Floats = NDArray[np.float64]

MAX_EXPANSION_ERROR = 0.1
"""Error of the expansion in the parameters, as a share of the residual, from which it is repeated."""
MAX_EXPANSIONS = 4
"""Expansions of the simulator in its parameters."""
MIN_VALUE_SHARE = 1e-3
"""Smallest share of a positive parameter at which the simulator is evaluated: zero masses cannot move."""
WARNING = (
    "the simulation is a black box: masses, payloads and a tilt of the base are not tested, and only its "
    "`parameters` are refitted"
)


class SimulatorUnderTest:
    """A black-box simulator for all episodes of a recording.

    Parameters
    ----------
    recording : JointRecording
    simulator : JointSimulator
    parameters : sequence of dict
        From `trundle.black_box.parse_parameters`.
    is_given : bool
        Whether the starting values are under test.
    """

    def __init__(
        self,
        recording: JointRecording,
        simulator: JointSimulator,
        parameters: Sequence[Mapping[str, Any]],
        *,
        is_given: bool,
    ) -> None:
        _refuse_other_mechanisms(recording)
        self.recording, self.simulator = recording, simulator
        self.parameters, self.is_given = [dict(one) for one in parameters], is_given
        self.values = {one["name"]: float(one["start"]) for one in parameters}
        self.joint_kinds, own = joint_types(recording)
        self.warnings = [WARNING, *own]
        self.expansions = 0
        self.arrays: dict[str, dict[str, Floats]] = {}

    @property
    def is_model_file(self) -> bool:
        """Whether it is an MJCF or URDF file."""
        return False

    def dynamics(self, motion: JointMotion, report: Report) -> dict[str, Any]:
        """Return what the native module needs of the mechanism along the recorded motion."""
        episodes = motion["episodes"]
        self.scale = self._scale(motion)
        shares = {}
        for k, name in enumerate(episodes):
            report("mechanism", k / len(episodes))
            self.arrays[name], shares[name] = self._episode(name, motion)
        if self.expansions == 0:
            self.warnings += _nonlinear(shares)
        self.expansions += 1
        n = self.simulator.n
        return {
            "bodies": [],
            "masses": [],
            **{key: [0.0] * n for key in ("armature", "damping", "frictionloss")},
            "gravity": [0.0] * 3,
            "is_hinge": [kind == "hinge" for kind in self.joint_kinds],
            "simulator": {
                "parameters": self.parameters,
                "references": list(self.values.values()),
                "is_given": self.is_given,
            },
            "episodes": self.arrays,
        }

    def _scale(self, motion: JointMotion) -> EffortScale:
        """Return the size of efforts in the first training episode."""
        training = [name for name in motion["episodes"] if not self.recording[name].held_out]
        name = (training or list(motion["episodes"]))[0]
        own = motion["episodes"][name]
        samples = Samples(name, own["t"])
        return effort_scale(self.simulator, samples, own["q"], own["v"], own["a"], self.values)

    def _episode(self, name: str, motion: JointMotion) -> tuple[dict[str, Floats], float]:
        own = motion["episodes"][name]
        q, v, n = own["q"], own["v"], self.simulator.n
        samples = Samples(name, own["t"])
        found = self._inverse(name, motion, self.values)
        place = (self.simulator, samples, q, v, self.values, found)
        arrays = {
            "effort": found.effort,
            "mass_matrix": found.mass_matrix,
            "mass": np.empty((len(q), n, 0)),
            "gravity": np.zeros((len(q), n, 3)),
            "payload": np.empty((len(q), n, 0, 10)),
            "matrix_mass": np.empty((len(q), n, 0, n)),
            "own_payload": np.empty((len(q), n, 0, 10)),
            "position": by_position(*place),
            "velocity": np.zeros((len(q), n, n)),
            "position_curvature": np.zeros((len(q), n, n)),
            "mass_gravity": np.empty((len(q), n, 0, 3)),
            "mass_position": np.empty((len(q), n, 0, n)),
            "parameter": by_parameter(*place, self.parameters),
        }
        contiguous = {key: np.ascontiguousarray(values, dtype=float) for key, values in arrays.items()}
        return contiguous, found.nonlinear_share

    def _inverse(self, name: str, motion: JointMotion, values: Mapping[str, float]) -> InverseDynamics:
        own = motion["episodes"][name]
        samples = Samples(name, own["t"])
        return inverse_dynamics(self.simulator, samples, own["q"], own["v"], own["a"], values, self.scale)

    def expand_again(self, motion: JointMotion, outcome: _JointOutcome) -> bool:
        """Choose fitted values for the next evaluation; False if the present one is accurate there."""
        values = self.values_of(outcome.models[1])
        if not values:
            return False
        change = np.array([values[name] - self.values[name] for name in values])
        residual = outcome.answer["residual"]["effort_rms"]
        sd = np.array([residual.get(joint, np.inf) for joint in self.simulator.joints])
        errors = []
        for name, arrays in self.arrays.items():
            if not self.recording[name].held_out:
                exact = self._inverse(name, motion, values).effort
                errors.append(exact - arrays["effort"] - arrays["parameter"] @ change)
        error = np.sqrt(np.mean(np.concatenate(errors) ** 2, axis=0))
        if (error <= MAX_EXPANSION_ERROR * sd).all():
            return False
        if self.expansions >= MAX_EXPANSIONS:
            worst = self.simulator.joints[int(np.argmax(error / np.maximum(sd, np.finfo(float).tiny)))]
            self.warnings.append(
                f"the effort of joint {worst} is not linear in the parameters of the simulator near the "
                "fitted values; give better starting values or bounds"
            )
            return False
        self.values = values
        return True

    def values_of(self, model: Mapping[str, Any]) -> dict[str, float]:
        """Return the values of the simulator's parameters in a fitted model."""
        found = {}
        for one in self.parameters:
            value = float(model["nominal"].get(one["name"], one["start"]))
            if one["lower"] == 0.0 and one["start"] > 0.0:
                value = max(value, MIN_VALUE_SHARE * one["start"])
            found[one["name"]] = value
        return found

    def fitted(self, episode: str, model: Mapping[str, Any]) -> FittedSimulator:
        """Return the simulator with the values of a fitted model."""
        return FittedSimulator(self, episode, model)

    def joint_before(self, body: str) -> str:
        """Raise an error: bodies of a black box are not known."""
        raise TrundleError(f"step: body {body}: the bodies of a black box are not known")


class FittedSimulator:
    """A simulator with fitted values: see `trundle.joint_diagnosis.under_test.FittedMechanism`."""

    def __init__(self, under_test: SimulatorUnderTest, episode: str, model: Mapping[str, Any]) -> None:
        self.simulator, self.scale = under_test.simulator, under_test.scale
        self.episode, self.values = episode, under_test.values_of(model)
        self.armature = np.zeros(self.simulator.n)
        self.can_simulate = not any(one["kind"] in COMPLIANT for one in model["effects"])
        for one in model["effects"]:
            if one["kind"] == "rotor_inertia":
                joint = self.simulator.joints.index(one["joint"])
                self.armature[joint] += one["values"]["armature"]

    def needed(self, t: Floats, q: Floats, v: Floats, a: Floats) -> tuple[Floats, Floats]:
        """Return the effort for a motion, and the diagonal of the mass matrix, (T, n) each."""
        samples = Samples(self.episode, t)
        found = inverse_dynamics(self.simulator, samples, q, v, a, self.values, self.scale)
        inertia = np.einsum("tii->ti", found.mass_matrix) + self.armature
        return found.effort + self.armature * a, inertia

    def simulate(
        self, t: Floats, q: Floats, v: Floats, drive: Drive, laws: JointLaws | None, known: Drive | None
    ) -> Floats:
        """Return positions, (T, n), in open loop from a state; NaN after a divergence."""
        place = (self.simulator, self.values, self.scale, self.episode)
        return simulate(*place, t, (q, v), drive, laws, known=known, armature=self.armature)


def joint_types(recording: JointRecording) -> tuple[list[str], list[str]]:
    """Return the type of each joint, "hinge" or "slide", and doubts about them."""
    mechanism, joints = recording.metadata["mechanism"], recording.joints
    given = mechanism.get("types", mechanism.get("axis"))
    if given is not None:
        return [given[joint] if isinstance(given, Mapping) else given for joint in joints], []
    try:
        return model_joint_kinds(recording), []
    except TrundleError as error:
        doubt = f"the model does not tell the types of the joints, and units are those of hinges: {error}"
        return ["hinge"] * len(joints), [doubt]


def _refuse_other_mechanisms(recording: JointRecording) -> None:
    """Refuse episodes with a payload or model of their own, which a black box does not know."""
    for name, table in recording.metadata.get("episode", {}).items():
        for key in ("payload", "model"):
            if key in table:
                raise TrundleError(
                    f"{recording.name}: [episode.{name}] has a {key}, which `step` does not know; diagnose "
                    "episodes with the same load in one recording, or use an MJCF model"
                )


def _nonlinear(shares: Mapping[str, float]) -> list[str]:
    """Return a warning if the simulator is not linear in the effort at some samples."""
    name = max(shares, key=lambda name: shares[name])
    if shares[name] == 0.0:
        return []
    return [
        f"the simulator is not linear in the efforts at {100 * shares[name]:.2g} % of the samples in motion "
        f"of episode {name}: efforts there are iterated"
    ]
