"""Logs of a Dynamixel XL330 servo that swings a pendulum, 200 Hz.

GitHub `Rhoban/bam`, `bam/data.bak/processed/`; M. Duclusaud et al., "Extended friction models for the
physics simulation of servo actuators", arXiv 2410.08650.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from trundle.importers.config import MapError, typed
from trundle.importers.joints.joint_map import FORMAT, merge
from trundle.importers.layout import Columns, Floats, Imported, ShowProgress, SourceError
from trundle.importers.xl330_log import ServoLog, mask_wraps, read_log

__all__ = ["NEEDS_MAP", "ServoMap", "read"]

NEEDS_MAP = False

JOINT = "arm"
GRAVITY = 9.81
PWM_FULL_SCALE = 885
"""Value of the PWM register at full voltage."""
STEPS_PER_TURN = 4096
SPEED_DELAY_S = 0.02
"""Delay of the logged speed, s."""
STIFFNESS_SCALE = STEPS_PER_TURN / (2.0 * np.pi) / (256 * PWM_FULL_SCALE)
"""Duty per gain and rad: the firmware applies duty = kp · error · `STIFFNESS_SCALE`."""
TORQUE_PER_VOLT = 0.3232 / 4.7637
"""kt/R of the published model `m1`, N·m/V."""


@dataclass(frozen=True)
class ServoMap:
    """Settings of the import; all are optional.

    Attributes
    ----------
    name : str
        Name of the recording.
    files : list of str
        Logs of a folder to read, without `.json`; by default all.
    held_out : list of str
        Held-out episodes; by default every fourth log after the first.
    drive : str
        "voltage": the motor's voltage is the effort. "target": the goal position drives, with the stiffness
        of the firmware's position loop.
    torque_per_volt : float
        Torque of the blocked motor per volt, N·m/V, for `drive = "target"`; by default a published estimate.
    recording : dict
        Tables that are added to `recording.toml`, or replace its values.
    """

    name: str | None = None
    files: list[str] | None = None
    held_out: list[str] | None = None
    drive: Literal["voltage", "target"] = "voltage"
    torque_per_volt: float = TORQUE_PER_VOLT
    recording: dict[str, Any] = field(default_factory=dict)


def read(source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
    """Read one log, or the logs of a folder; each is an episode."""
    options = typed(ServoMap, settings)
    logs: dict[str, ServoLog] = {}
    for path in _paths(source, options.files):
        say(path.name)
        log = read_log(path)
        if log is not None:
            logs[path.stem] = log
    if not logs:
        raise SourceError(source, "no log with `entries`; give a file of the data set, or their folder")
    episodes: dict[str, Columns] = {}
    remarks: list[str] = []
    for name, log in logs.items():
        duty, masked = mask_wraps(log.columns["load"])
        episodes[name] = _table(log, duty / PWM_FULL_SCALE, options.drive)
        if masked and options.drive == "voltage":
            remarks.append(
                f"{name}: {masked} samples of effort_{JOINT} between two values of the register masked"
            )
    metadata = merge(_metadata(source, logs, options), options.recording)
    return Imported(metadata, episodes, remarks, _models(logs))


def _paths(source: Path, chosen: list[str] | None) -> list[Path]:
    if not source.is_dir():
        if chosen is not None:
            raise MapError("`files`: applies only to a folder; remove it for a single file")
        return [source]
    return sorted(source.glob("*.json")) if chosen is None else [source / f"{name}.json" for name in chosen]


def _table(log: ServoLog, duty: Floats, drive: str) -> Columns:
    """Return the columns of an episode."""
    columns = log.columns
    table = {
        "t": columns["timestamp"] - columns["timestamp"][0],
        f"q_{JOINT}": columns["position"],
        f"v_{JOINT}": columns["speed"],
        f"target_{JOINT}": columns["goal_position"],
        f"on_{JOINT}": columns["torque_enable"],
    }
    return table if drive == "target" else table | {f"effort_{JOINT}": duty * columns["input_volts"]}


def _metadata(source: Path, logs: Mapping[str, ServoLog], options: ServoMap) -> dict[str, Any]:
    """Return the content of `recording.toml`."""
    held_out = list(logs)[4::4] if options.held_out is None else options.held_out
    mechanism, loads = _mechanism(logs)
    drive, drives = _drive(logs, options)
    episode = merge(loads, drives)
    return {
        "format": FORMAT,
        "name": options.name or f"XL330 servo with a pendulum, {source.stem}",
        "mechanism": {**mechanism, "joints": [JOINT]},
        **drive,
        "noise": {"position_step": 2.0 * np.pi / STEPS_PER_TURN},
        "delay": {"v": SPEED_DELAY_S},
        **({"episode": episode} if episode else {}),
        **({"split": {"held_out": held_out}} if held_out else {}),
        "notes": {
            "origin": "github.com/Rhoban/bam, bam/data.bak/processed; arXiv 2410.08650",
            "licence": "Apache-2.0",
            "load": "inertia = mass length², gravity_torque = mass g length, without motor and arm",
            "effort": "motor voltage = load / 885 · input_volts, signed PWM register",
            "logs": {
                name: {"trajectory": log.trajectory, "kp": log.kp, "vin": log.vin}
                for name, log in logs.items()
            },
        },
    }


def _mechanism(logs: Mapping[str, ServoLog]) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
    """Return the table of the mechanism, and the tables of the episodes if the logs have several loads."""
    first = next(iter(logs.values()))
    if len(_loads(logs)) > 1:
        model = {"model": _model_name(first), "free": [f"armature:{JOINT}", f"damping:{JOINT}"]}
        return model, {name: {"model": _model_name(log)} for name, log in logs.items()}
    axis = {
        "axis": "hinge",
        "gravity": True,
        "inertia": first.mass * first.length**2,
        "gravity_torque": first.mass * GRAVITY * first.length,
    }
    return axis, {}


def _drive(
    logs: Mapping[str, ServoLog], options: ServoMap
) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
    """Return the table of the drive, and those of the episodes whose gain or voltage differs."""
    if options.drive == "voltage":
        return {"effort": {"source": "voltage", "gain": "free"}}, {}
    loops = {}
    for name, log in logs.items():
        blocked = options.torque_per_volt * log.vin
        loops[name] = {"stiffness": blocked * log.kp * STIFFNESS_SCALE, "limit": blocked}
    common = next(iter(loops.values()))
    different = {name: loop for name, loop in loops.items() if loop != common}
    return {"target": {**common, "damping": "free"}}, different


def _loads(logs: Mapping[str, ServoLog]) -> set[tuple[float, float]]:
    return {(log.mass, log.length) for log in logs.values()}


def _model_name(log: ServoLog) -> str:
    return f"pendulum_{log.mass:g}kg_{log.length:g}m.xml"


def _models(logs: Mapping[str, ServoLog]) -> dict[str, str]:
    """Return a model for each load, if the logs have several."""
    if len(_loads(logs)) == 1:
        return {}
    return {
        _model_name(log): f"""<mujoco model="pendulum">
  <option gravity="0 0 -{GRAVITY}"/>
  <worldbody>
    <body name="load">
      <joint name="{JOINT}" type="hinge" axis="0 1 0"/>
      <inertial pos="0 0 -{log.length:g}" mass="{log.mass:g}" diaginertia="1e-9 1e-9 1e-9"/>
    </body>
  </worldbody>
</mujoco>
"""
        for log in logs.values()
    }
