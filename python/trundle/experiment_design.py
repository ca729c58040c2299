"""`trundle.design`: discriminating experiments for pushed objects and for mechanisms."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from trundle._native import JointRecording, Model, Recording, TrundleError, read
from trundle.design import DEFAULT_NOISE_SD, Design, design_pushes
from trundle.joint_diagnosis import open_joints
from trundle.native_inputs import PathLike
from trundle.progress import ProgressOption

if TYPE_CHECKING:
    from trundle.joint_design import AxisLoad, JointDesign
    from trundle.mechanism import MechanismModel, Payload

__all__ = ["design"]

PUSHED_OPTIONS = ("noise", "pushes", "force", "torque", "spin", "distance")
"""Options that only designs of pushes have."""
JOINT_OPTIONS = ("mjcf", "position", "acceleration", "effort", "loads")
"""Options that only designs of trajectories have."""


@overload
def design(
    model_a: MechanismModel | PathLike,
    model_b: MechanismModel | PathLike,
    *,
    recording: JointRecording,
    mjcf: PathLike | None = ...,
    duration: float | None = ...,
    position: Mapping[str, tuple[float, float]] | None = ...,
    speed: float | Mapping[str, float] | None = ...,
    acceleration: float | Mapping[str, float] | None = ...,
    effort: float | Mapping[str, float] | None = ...,
    loads: Sequence[AxisLoad | Payload] = ...,
    progress: ProgressOption = ...,
) -> JointDesign: ...
@overload
def design(
    model_a: Model | PathLike,
    model_b: Model | PathLike,
    *,
    recording: Recording | None = ...,
    object: PathLike | None = ...,
    noise: tuple[float, float, float, float] = ...,
    pushes: int = ...,
    force: float | None = ...,
    torque: float | None = ...,
    duration: float | None = ...,
    speed: float | None = ...,
    spin: float | None = ...,
    distance: float | None = ...,
    progress: ProgressOption = ...,
) -> Design: ...
@overload
def design(
    model_a: Model | MechanismModel | PathLike,
    model_b: Model | MechanismModel | PathLike,
    *,
    recording: PathLike,
    mjcf: PathLike | None = ...,
    noise: tuple[float, float, float, float] = ...,
    pushes: int = ...,
    force: float | None = ...,
    torque: float | None = ...,
    duration: float | None = ...,
    speed: float | Mapping[str, float] | None = ...,
    spin: float | None = ...,
    distance: float | None = ...,
    position: Mapping[str, tuple[float, float]] | None = ...,
    acceleration: float | Mapping[str, float] | None = ...,
    effort: float | Mapping[str, float] | None = ...,
    loads: Sequence[AxisLoad | Payload] = ...,
    progress: ProgressOption = ...,
) -> Design | Any: ...
def design(
    model_a: Model | MechanismModel | PathLike,
    model_b: Model | MechanismModel | PathLike,
    *,
    recording: Recording | JointRecording | PathLike | None = None,
    object: PathLike | None = None,
    mjcf: PathLike | None = None,
    noise: tuple[float, float, float, float] = DEFAULT_NOISE_SD,
    pushes: int = 1,
    force: float | None = None,
    torque: float | None = None,
    duration: float | None = None,
    speed: float | Mapping[str, float] | None = None,
    spin: float | None = None,
    distance: float | None = None,
    position: Mapping[str, tuple[float, float]] | None = None,
    acceleration: float | Mapping[str, float] | None = None,
    effort: float | Mapping[str, float] | None = None,
    loads: Sequence[AxisLoad | Payload] = (),
    progress: ProgressOption = None,
) -> Design | JointDesign:
    """Find the experiment that best discriminates two models.

    For a pushed object these are pushes. For a recording of joints it is a trajectory that the drives make
    the joints follow or, where no trajectory is enough, a change of the load or of the rig. Each model is
    compared with the best refit of the other one; docs/design.md and docs/mechanisms.md describe the methods.

    Parameters
    ----------
    model_a, model_b : Model, MechanismModel, path or str
        With a recording, both are fitted to it. Without one, all values must be given; their uncertainty is
        the posterior in the model file, or else the priors of the catalogue. For a recording of joints:
        `trundle-model/2` files, or names of effects, "joint_dry_friction:elbow", joined by "+";
        "nominal" is the model without effects.
    recording : Recording, JointRecording or path, optional
        It provides previous episodes, the noise and the instruments. Required for joints.
    object : path, optional
        An object or model file with a ``[body]``, for models that have no footprint; or the folder of a
        recording of joints.
    mjcf : path, optional
        Joints: replaces the recording's model; with it, `recording` may be a CSV log.
    noise : tuple of four floats
        Pushes: standard deviations of position (m), heading (rad), force (N) and torque (N·m) without a
        recording.
    pushes : int
        Number of pushes; each is the best in addition to the previous ones.
    force, torque, spin, distance : float, optional
        Pushes: limits of a push (N, N·m) and of the motion of the object (rad/s, m). The defaults are those
        of the recording; without one they are 30, 8, 1, 1.2.
    duration : float, optional
        Duration of a push or trajectory, s. Default: as recorded, or 6 s; for joints at most 20 s.
    speed : float or mapping of str to float, optional
        Largest speed of the object, m/s (default: as recorded, or 0.6), or of the joints.
    position : mapping of str to (float, float), optional
        Joints: range by joint, rad or m. Default: as recorded.
    acceleration, effort : float or mapping of str to float, optional
        Joints: largest values, for all joints or by joint. Default: as recorded. A given effort also holds
        with a changed load; the recorded one does not.
    loads : sequence of AxisLoad or Payload, optional
        Joints: changes of the load that are compared. By default typical ones are tried if no trajectory on
        the recorded rig is enough.
    progress : bool or callable, optional
        True shows a progress bar; the default shows one in notebooks only. A function is called with the
        stage of the work and the finished share of all work, 0 to 1, which never decreases.

    Returns
    -------
    Design or JointDesign

    Raises
    ------
    TrundleError
        If a model has no footprint or no value for a parameter, cannot be fitted, an effect or joint is
        unknown, a joint has no drive, or a limit is not positive.

    Notes
    -----
    The design for joints assumes: the drives make the joints follow the trajectory exactly; one of the two
    models is true at its fitted values; the effort's noise is that of the fit's residual, independent of the
    motion; a changed load is known exactly, and everything else of the rig stays. Resting joints do not
    count, because dry friction hides their effort.

    Examples
    --------
    >>> design = trundle.design("model.toml", "wheel.toml", force=60.0, duration=2.0)
    >>> design.models
    ('coulomb_friction', 'a model without coulomb_friction')
    """
    given = dict(locals())
    source = _opened(recording, object, mjcf)
    if isinstance(source, JointRecording):
        _refuse(given, PUSHED_OPTIONS, f"{source.name} is a recording of joints")
        from trundle.joint_design import design_joints
        from trundle.joint_design.limits import GivenLimits

        limits = GivenLimits(position, speed, acceleration, effort)
        return design_joints(
            model_a, model_b, source, mjcf, limits=limits, duration=duration, loads=loads, progress=progress
        )
    _refuse(given, JOINT_OPTIONS, "these are models of a pushed object")
    first, second = (_pushed(model) for model in (model_a, model_b))
    if isinstance(speed, Mapping):
        raise TrundleError("speed: a pushed object has one speed; give a number in m/s")
    return design_pushes(
        first,
        second,
        recording=source,
        object=object,
        noise=noise,
        pushes=pushes,
        limits={
            "force": force,
            "torque": torque,
            "duration": duration,
            "speed": speed,
            "spin": spin,
            "distance": distance,
        },
        progress=progress,
    )


def _opened(
    recording: Recording | JointRecording | PathLike | None, object: PathLike | None, mjcf: PathLike | None
) -> Recording | JointRecording | None:
    """Return the recording; a folder in `object` is one if it holds joints."""
    if recording is not None:
        if isinstance(recording, Recording | JointRecording):
            return recording
        return open_joints(recording, mjcf) or read(recording)
    if object is not None and (mjcf is not None or (Path(object) / "recording.toml").is_file()):
        return open_joints(object, mjcf)
    return None


def _refuse(given: Mapping[str, Any], names: Sequence[str], reason: str) -> None:
    """Refuse options that have another value than their default."""
    defaults = {"noise": DEFAULT_NOISE_SD, "pushes": 1, "loads": ()}
    for name in names:
        if given[name] != defaults.get(name):
            raise TrundleError(f"{name} = {given[name]}: {reason}, which has no such option; remove it")


def _pushed(model: Model | MechanismModel | PathLike) -> Model | PathLike:
    """Return a model of a pushed object, or its path."""
    if isinstance(model, Model | str | os.PathLike):
        return model
    raise TrundleError("this is a model of a mechanism; give the recording of its joints as `recording`")
