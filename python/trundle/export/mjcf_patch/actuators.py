"""Effects of drives: gain, bias, delay, lag, saturation, and controllers of position."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from trundle.export.mjcf_patch.specification import Patch
from trundle.mechanism import JointEffect
from trundle.mechanism.source import import_mujoco

__all__ = ["ACTUATOR_EFFECTS", "find_drives", "set_target_drive"]


def find_drives(patch: Patch, joint: str) -> list[Any]:
    """Return the actuators of a joint; a new motor if the model has none."""
    mujoco = import_mujoco()
    kinds = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    found = [one for one in patch.spec.actuators if one.trntype in kinds and one.target == joint]
    if not found:
        motor = patch.spec.add_actuator(name=f"{joint}_drive")
        motor.trntype, motor.target = mujoco.mjtTrn.mjTRN_JOINT, joint
        patch.notes.append(f"Motor {motor.name!r} is new: its control is the recorded effort of {joint!r}.")
        found = [motor]
    return found


def is_motor(actuator: Any) -> bool:
    """Return whether the force of an actuator is proportional to its control."""
    return bool(actuator.biastype == import_mujoco().mjtBias.mjBIAS_NONE)


def set_target_drive(patch: Patch, joint: str, values: dict[str, float]) -> None:
    """Make the actuators of a joint controllers of position, with stiffness, damping and limit."""
    mujoco = import_mujoco()
    for actuator in find_drives(patch, joint):
        stiffness = values.get("target_stiffness", float(actuator.gainprm[0]))
        actuator.set_to_position(stiffness, values.get("target_damping", -float(actuator.biasprm[2])))
        actuator.gear = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        if "target_limit" in values:
            limit = values["target_limit"]
            actuator.forcerange = [-limit, limit]
            actuator.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE


def set_gain(patch: Patch, effect: JointEffect) -> None:
    """Divide by the gain of the reading: the control is the recorded effort, the force the true one."""
    gain = effect.parameters["gain"]
    for actuator in motors(patch, effect):
        actuator.gainprm[0] /= gain


def set_bias(patch: Patch, effect: JointEffect) -> None:
    """Subtract the bias of the reading."""
    affine = import_mujoco().mjtBias.mjBIAS_AFFINE
    for actuator in motors(patch, effect):
        actuator.biastype = affine
        actuator.biasprm[0] -= actuator.gainprm[0] * effect.parameters["bias"]


def motors(patch: Patch, effect: JointEffect) -> list[Any]:
    """Return the actuators of an effect of the effort's reading, if they are motors."""
    found = find_drives(patch, patch.joint(effect).name)
    if not all(is_motor(actuator) for actuator in found):
        patch.notes.append(
            f"{effect.name} is not expressed: the actuator's control is not the recorded effort."
        )
        return []
    return found


def set_delay(patch: Patch, effect: JointEffect) -> None:
    """Delay the control of a drive."""
    delay_control(patch, effect, find_drives(patch, patch.joint(effect).name), effect.parameters["delay"])


def set_reading_delay(patch: Patch, effect: JointEffect) -> None:
    """Delay the control, the recorded effort, if it was recorded before it acts."""
    delay = -effect.parameters["delay"]
    if delay > 0.0:
        delay_control(patch, effect, motors(patch, effect), delay)
    else:
        note_instrument(patch, effect)


def note_instrument(patch: Patch, effect: JointEffect) -> None:
    """Note an effect of the recorded effort that a simulation does not have."""
    patch.notes.append(f"{effect.name} is a property of the recorded effort and not part of the model.")


def delay_control(patch: Patch, effect: JointEffect, actuators: list[Any], delay: float) -> None:
    """Delay the control of actuators further; the buffer holds enough samples for the model's step."""
    if not actuators:
        return
    for actuator in actuators:
        actuator.delay += delay
        actuator.nsample = math.ceil(actuator.delay / patch.original.opt.timestep) + 1
    patch.notes.append(
        f"{effect.name}: `nsample` fits the model's timestep; raise it if you shorten the step."
    )


def set_lag(patch: Patch, effect: JointEffect) -> None:
    """Filter the control with a first-order lag, integrated exactly."""
    dynamics = import_mujoco().mjtDyn
    for actuator in find_drives(patch, patch.joint(effect).name):
        if actuator.dyntype != dynamics.mjDYN_NONE:
            patch.notes.append(
                f"{effect.name} is not expressed: actuator {actuator.name!r} has dynamics of its own."
            )
            continue
        actuator.dyntype = dynamics.mjDYN_FILTEREXACT
        actuator.dynprm[0] = effect.parameters["time_constant"]
        for key in list(patch.spec.keys):
            patch.spec.delete(key)


def set_limit(patch: Patch, effect: JointEffect) -> None:
    """Limit the force of the actuators."""
    limit = effect.parameters["limit"]
    for actuator in find_drives(patch, patch.joint(effect).name):
        scale = abs(float(actuator.gear[0]))
        actuator.forcerange = [-limit / scale, limit / scale]
        actuator.forcelimited = import_mujoco().mjtLimited.mjLIMITED_TRUE


def compute_droop(patch: Patch, effect: JointEffect) -> None:
    """Leave a gain that falls with the command to the callback."""
    if "max_effort" not in effect.parameters:
        patch.notes.append(
            f"{effect.name} is relative to the largest effort so far; give max_effort in effects.json."
        )
    find_drives(patch, patch.joint(effect).name)
    patch.compute(effect)


ACTUATOR_EFFECTS: dict[str, Callable[[Patch, JointEffect], None]] = {
    "effort_gain": set_gain,
    "effort_bias": set_bias,
    "effort_delay": set_reading_delay,
    "effort_lag": note_instrument,
    "drive_delay": set_delay,
    "drive_lag": set_lag,
    "effort_saturation": set_limit,
    "drive_gain_droop": compute_droop,
}
"""Functions by the kind of the effect, in the order in which they are applied."""
