"""The mechanisms of a recording's episodes, and their dynamics along the recorded motion."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from trundle._native import JointRecording, TrundleError, _JointOutcome
from trundle._optional import require
from trundle._types import JointMotion
from trundle.joint_diagnosis.fitted import FittedModel
from trundle.joint_diagnosis.signals import JointSignals, read_signals, setting
from trundle.joint_diagnosis.under_test import Report

if TYPE_CHECKING:
    from trundle.mechanism import Mechanism, Payload

__all__ = [
    "EpisodeMechanisms",
    "load_mechanisms",
    "load_with_payload",
    "model_joint_kinds",
    "motion_dynamics",
]

MAX_CONTACT_SHARE = 0.5
"""Share of the effort of a joint from which contacts of the model must agree with the recording."""

HINGE = 3
"""MuJoCo's type of a hinge, mjtJoint.mjJNT_HINGE."""

PathLike = str | os.PathLike[str]


class EpisodeMechanisms:
    """The mechanism of each episode.

    Attributes
    ----------
    by_episode : dict of str to Mechanism
    warnings : list of str
        Doubts about the model.
    on_drive : frozenset of str
        Joints whose encoder is at the drive.
    """

    def __init__(
        self, by_episode: Mapping[str, Mechanism], warnings: list[str], on_drive: Iterable[str] = ()
    ) -> None:
        self.by_episode, self.on_drive = dict(by_episode), frozenset(on_drive)
        self.warnings = warnings

    @property
    def first(self) -> Mechanism:
        """The mechanism of the first episode, whose nominal values all share."""
        return next(iter(self.by_episode.values()))

    @property
    def joint_kinds(self) -> list[str]:
        """The kind of each recorded joint: "hinge" or "slide"."""
        first = self.first
        return ["hinge" if first.compiled.jnt_type[k] == HINGE else "slide" for k in first.coordinates.index]

    @property
    def is_model_file(self) -> bool:
        """Whether it is an MJCF or URDF file."""
        return True

    def dynamics(self, motion: JointMotion, report: Report) -> dict[str, Any]:
        """Return what the native module needs of the mechanism along the recorded motion."""
        report("mechanism", 0.0)
        return _dynamics(self, motion)

    def expand_again(self, motion: JointMotion, outcome: _JointOutcome) -> bool:
        """Return False: efforts are linear in all fitted values."""
        return False

    def fitted(self, episode: str, model: Mapping[str, Any]) -> FittedModel:
        """Return the mechanism of an episode with the values of a fitted model."""
        return FittedModel(self.by_episode[episode], model, self.on_drive)

    def joint_before(self, body: str) -> str:
        """Return the last recorded joint before a body."""
        group = next(group for group in self.first.groups if group.name == body)
        return self.first.joints[int(self.first.coordinates.source[group.chain[-1]])]


def load_mechanisms(
    recording: JointRecording, motion: JointMotion, mjcf: PathLike | None = None
) -> EpisodeMechanisms:
    """Load the model of every episode, with its payload.

    If contacts between bodies of the model dominate the effort of a joint in a training episode, and what
    drives the joint agrees better with the model without them, the mechanisms have no contacts.

    Parameters
    ----------
    recording : JointRecording
    motion : dict
        From the native module.
    mjcf : path, optional
        Replaces the model of the recording.

    Raises
    ------
    TrundleError
        If MuJoCo is missing, a model cannot be loaded or does not have the recorded joints.
    """
    require("mujoco", "mujoco", "mechanisms with a model")
    from trundle.mechanism import touching_bodies

    def side(joint: str) -> Any:
        return setting(recording.metadata, "", "encoder", "side", joint, "joint")

    on_drive = [joint for joint in recording.joints if side(joint) == "drive"]
    with model_folder(recording) as folder:
        found = _load(recording, folder, mjcf, contacts=True)
        apart: dict[str, Mechanism] = {}
        for name, mechanism in found.items():
            if recording[name].held_out:
                continue
            own = motion["episodes"][name]
            rows = slice(None, None, max(1, len(own["q"]) // 200))
            at = [own[key][rows] for key in ("q", "v", "a")]
            pairs = list(touching_bodies(mechanism, at[0]))
            if not pairs:
                continue
            apart = apart or _load(recording, folder, mjcf, contacts=False)
            efforts = [each[name].regressors(*at, derivatives=False).effort for each in (found, apart)]
            signals = [read_signals(recording, name, joint, own["t"][rows]) for joint in recording.joints]
            if _contradicts_contacts(efforts, signals, at):
                return EpisodeMechanisms(apart, [_warning(pairs)], on_drive)
    return EpisodeMechanisms(found, [], on_drive)


def model_joint_kinds(recording: JointRecording) -> list[str]:
    """Return the kind of each recorded joint in the recording's model: "hinge" or "slide"."""
    require("mujoco", "mujoco", "mechanisms with a model")
    with model_folder(recording) as folder:
        return EpisodeMechanisms(_load(recording, folder, None, contacts=False), []).joint_kinds


def _load(
    recording: JointRecording, folder: Path, mjcf: PathLike | None, *, contacts: bool
) -> dict[str, Mechanism]:
    from trundle.mechanism import Mechanism

    metadata = recording.metadata
    tables = metadata.get("episode", {})
    loaded: dict[str, Mechanism] = {}
    found = {}
    for name in recording:
        table = tables.get(name, {})
        payload = table.get("payload")
        model = table.get("model")
        source = folder / model if model else Path(mjcf) if mjcf else folder / metadata["mechanism"]["model"]
        key = f"{source} {payload}"
        if key not in loaded:
            carried = None if payload is None else _payload(payload)
            loaded[key] = Mechanism.load(source, recording.joints, payload=carried, contacts=contacts)
            if loaded[key].bodies != next(iter(loaded.values())).bodies:
                raise TrundleError(
                    f"{recording.name}: episode {name}: the model has other moving bodies than that of the "
                    "first episode; use models that differ in their values only"
                )
        found[name] = loaded[key]
    return found


def load_with_payload(
    recording: JointRecording, mjcf: PathLike | None, payload: Payload, *, contacts: bool
) -> Mechanism:
    """Load the model of a recording, or the file that replaces it, with another payload."""
    from trundle.mechanism import Mechanism

    with model_folder(recording) as folder:
        source = Path(mjcf) if mjcf else folder / recording.metadata["mechanism"]["model"]
        return Mechanism.load(source, recording.joints, payload=payload, contacts=contacts)


def _payload(table: Mapping[str, Any]) -> Payload:
    from trundle.mechanism import Payload

    x, y, z = table.get("com", (0.0, 0.0, 0.0))
    return Payload(table["body"], table["mass"], (x, y, z))


@contextmanager
def model_folder(recording: JointRecording) -> Iterator[Path]:
    """Yield a temporary folder with the files of a recording."""
    with TemporaryDirectory() as temporary:
        for name, content in recording.files.items():
            target = Path(temporary) / name
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
        yield Path(temporary)


def _contradicts_contacts(
    efforts: Sequence[NDArray[np.float64]],
    signals: Sequence[JointSignals],
    at: Sequence[NDArray[np.float64]],
) -> bool:
    """Whether a joint's drive agrees better with the effort without contacts, where contacts dominate it.

    `efforts` are those of the model with and without contacts, `at` positions, velocities and accelerations.
    """
    touching, apart = efforts
    size = np.sqrt(np.mean(touching**2, axis=0))
    contact = np.sqrt(np.mean((touching - apart) ** 2, axis=0))
    dominated = np.flatnonzero(contact > MAX_CONTACT_SHARE * np.maximum(size, 1e-12)).tolist()
    return any(
        _unexplained_share(touching[:, j], signals[j], at, j)
        > _unexplained_share(apart[:, j], signals[j], at, j)
        for j in dominated
    )


def _unexplained_share(
    effort: NDArray[np.float64], signal: JointSignals, at: Sequence[NDArray[np.float64]], j: int
) -> float:
    """Return the share of an effort that the drive, velocity and acceleration of the joint do not explain."""
    q, v, a = at
    drive = signal.command - q[:, j] if signal.drive == "target" else signal.command
    columns = np.column_stack([drive, v[:, j], a[:, j], np.ones_like(drive)])
    residual = effort - columns @ np.linalg.lstsq(columns, effort)[0]
    return float(np.var(residual)) / max(float(np.var(effort)), 1e-300)


def _warning(pairs: list[tuple[str, str]]) -> str:
    listed = ", ".join(f"{first} and {second}" for first, second in pairs)
    return (
        f"the model's bodies {listed} touch at the recorded positions, which the drives contradict: contacts "
        "between bodies are ignored; exclude the pairs in the model if the real links do not touch"
    )


def _dynamics(mechanisms: EpisodeMechanisms, motion: JointMotion) -> dict[str, Any]:
    """Return what the native module needs of a mechanism along the recorded motion.

    Parameters
    ----------
    mechanisms : EpisodeMechanisms
    motion : dict
        From the native module.

    Returns
    -------
    dict
        Nominal values, and by episode the effort without armature, damping and friction, (T, n), with its
        derivatives: see `trundle.mechanism.Regressors`.
    """
    first = mechanisms.first
    return {
        "bodies": list(first.bodies),
        "masses": [first.masses[body] for body in first.bodies],
        "armature": first.armature.tolist(),
        "damping": first.damping.tolist(),
        "frictionloss": first.frictionloss.tolist(),
        "gravity": [float(value) for value in first.compiled.opt.gravity],
        "is_hinge": [kind == "hinge" for kind in mechanisms.joint_kinds],
        "episodes": {
            name: motion_dynamics(mechanisms.by_episode[name], own)
            for name, own in motion["episodes"].items()
        },
    }


def motion_dynamics(
    mechanism: Mechanism, own: Any, *, derivatives: bool = True
) -> dict[str, NDArray[np.float64]]:
    """Return the effort that a mechanism needs along one motion, and its derivatives.

    Parameters
    ----------
    mechanism : Mechanism
    own : mapping
        Positions, velocities and accelerations "q", "v" and "a", (T, n).
    derivatives : bool
        Whether to evaluate derivatives by position, which take most of the time; otherwise they are zero.
    """
    found = mechanism.regressors(own["q"], own["v"], own["a"], derivatives=derivatives)
    armature, damping = mechanism.armature, mechanism.damping
    bodies, (samples, n) = mechanism.bodies, found.effort.shape
    nothing = np.zeros((samples, n, n))
    zeros = dict.fromkeys(bodies, nothing)
    arrays = {
        "effort": found.effort - found.friction - armature * own["a"] - damping * own["v"],
        "mass_matrix": found.mass_matrix - np.diag(armature),
        "mass": _by_body(found.mass, bodies),
        "gravity": found.gravity,
        "payload": _by_body(found.payload, bodies),
        "matrix_mass": _by_body(found.matrix_mass, bodies),
        "own_payload": _by_body(found.own_payload, bodies),
        "mass_gravity": _by_body(found.mass_gravity, bodies),
        "mass_position": _by_body(found.mass_position or zeros, bodies),
        "position": nothing if found.position is None else found.position,
        "position_curvature": nothing if found.curvature is None else found.curvature,
        "velocity": nothing if found.velocity is None else found.velocity - np.diag(damping),
    }
    return {name: np.ascontiguousarray(values, dtype=float) for name, values in arrays.items()}


def _by_body(columns: Mapping[str, NDArray[np.float64]], bodies: Sequence[str]) -> NDArray[np.float64]:
    """Return columns, (T, n, ...), stacked along a third axis of bodies."""
    return np.stack([columns[body] for body in bodies], 2)
