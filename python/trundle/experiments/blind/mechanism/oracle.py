"""Held-out effort misfit of the refitted nominal model, from which materiality is decided."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import tomllib
from scipy.signal import butter, sosfiltfilt

from trundle import _native
from trundle.experiments.sampling import Floats
from trundle.mechanism import Mechanism, Payload

__all__ = ["effort_misfit"]

SPREAD = {"mass": 0.3, "armature": 1.0, "damping": 1.0}
"""Prior standard deviations of the nominal parameters, relative to the given values."""
RELATIVE_NOISE = 1e-3
"""Effort noise against which the prior is weighed, relative to the range of the effort."""
FILTER_SHARE = 0.7
"""Cut-off of the efforts, as a share of the bandwidth of the motion."""


def effort_misfit(folder: Path) -> float:
    """Return the held-out effort misfit of the refitted nominal model, relative to the efforts' range.

    The free parameters are fitted by least squares to the low-passed efforts, with the format's prior. For
    targets without efforts, the effort is the controller's, of known stiffness and damping or of free ones.
    """
    settings, mechanisms, motion = load_recording(folder)
    joints, free = motion["joints"], settings["mechanism"]["free"]
    parts = {
        name: episode_rows(folder, name, settings, mechanisms[name], motion, free) for name in mechanisms
    }
    held = set(settings["split"]["held_out"])
    n = len(joints)
    train = [part for name, part in parts.items() if name not in held]
    test = [part for name, part in parts.items() if name in held]
    y = np.concatenate([part[0] for part in train])
    scale = np.ptp(y, axis=0) + 1e-12
    columns = np.concatenate([part[1] for part in train])
    first = next(iter(mechanisms.values()))
    spread = np.array([given(first, name) * SPREAD[name.split(":")[0]] for name in free])
    spread = np.concatenate([spread, np.full(columns.shape[2] - len(free), np.inf)])
    a = (columns / scale[:, None] / RELATIVE_NOISE).reshape(-1, columns.shape[2])
    prior = np.diag(1.0 / spread)
    rows = np.vstack([a, prior])
    right = np.concatenate([(y / scale / RELATIVE_NOISE).ravel(), np.zeros(len(prior))])
    values = np.linalg.lstsq(rows, right, rcond=None)[0]
    residual = np.concatenate([part[0] - part[1] @ values for part in test]).reshape(-1, n)
    return float(np.sqrt(np.mean((residual / scale) ** 2)))


def given(mechanism: Mechanism, name: str) -> float:
    """Return the given value of a parameter of the nominal model."""
    kind, place = name.split(":")
    if kind == "mass":
        return float(mechanism.masses[place])
    return float(getattr(mechanism, kind)[mechanism.joints.index(place)])


def episode_rows(
    folder: Path,
    name: str,
    settings: dict[str, Any],
    mechanism: Mechanism,
    motion: dict[str, Any],
    free: list[str],
) -> tuple[Floats, Floats]:
    """Return low-passed efforts less the given model's, (T, n), and the columns of the free parameters."""
    one, joints = motion["episodes"][name], motion["joints"]
    found = mechanism.regressors(one["q"], one["v"], one["a"], derivatives=False)
    table = read_table(folder / f"{name}.csv")
    columns = np.zeros((*one["q"].shape, len(free)))
    for k, parameter in enumerate(free):
        kind, place = parameter.split(":")
        if kind == "mass":
            columns[:, :, k] = found.mass[place]
        else:
            j = joints.index(place)
            columns[:, j, k] = one["a" if kind == "armature" else "v"][:, j]
    held = settings.get("effort", {}).get("source") == "commanded" or "target" in settings
    seen = np.column_stack([sample(table, joint, one["t"], held) for joint in joints])
    effort = seen * settings.get("effort", {}).get("gain", 1.0)
    extra = np.zeros((*one["q"].shape, 0))
    if "target" in settings:
        stiffness, damping = settings["target"]["stiffness"], settings["target"]["damping"]
        error = seen - one["q"]
        if stiffness == "free":
            # The target error is the effort divided by the unknown stiffness of each joint.
            extra = np.zeros((*one["q"].shape, 2 * len(joints)))
            for j in range(len(joints)):
                extra[:, j, 2 * j], extra[:, j, 2 * j + 1] = found.effort[:, j], one["v"][:, j]
            return low_pass(error, motion, one), low_pass(
                np.concatenate([0 * columns, extra], 2), motion, one
            )
        kp, kd = (np.array([table_[joint] for joint in joints]) for table_ in (stiffness, damping))
        effort = kp * error - kd * one["v"]
    right = effort - (found.effort - found.friction)
    return low_pass(right, motion, one), low_pass(columns, motion, one)


def read_table(path: Path) -> dict[str, Floats]:
    """Return the columns of a table by name."""
    names = path.read_text(encoding="utf-8").split("\n", 1)[0].split(",")
    return dict(zip(names, np.loadtxt(path, delimiter=",", skiprows=1, unpack=True), strict=True))


def sample(table: dict[str, Floats], joint: str, t: Floats, held: bool) -> Any:
    """Return efforts or targets of a joint at other times, interpolated or held."""
    key = f"effort_{joint}" if f"effort_{joint}" in table else f"target_{joint}"
    if not held:
        return np.interp(t, table["t"], table[key])
    return table[key][
        np.clip(np.searchsorted(table["t"], t + 1e-9, side="right") - 1, 0, len(table[key]) - 1)
    ]


def low_pass(values: Floats, motion: dict[str, Any], one: dict[str, Any]) -> Any:
    """Return values below the bandwidth of the motion, without the ends of the episode."""
    rate = 1.0 / float(np.median(np.diff(one["t"])))
    cut = min(FILTER_SHARE * motion["bandwidth"], 0.4 * rate)
    found = sosfiltfilt(butter(2, cut, fs=rate, output="sos"), values, axis=0)
    ends = min(int(rate / cut), len(found) // 5)
    return found[ends : len(found) - ends]


def load_recording(folder: Path) -> tuple[dict[str, Any], dict[str, Mechanism], dict[str, Any]]:
    """Return the settings of a recording, its mechanism by episode, and its smoothed motion."""
    settings = tomllib.loads((folder / "recording.toml").read_text(encoding="utf-8"))
    motion: dict[str, Any] = {**_native._joint_motion(folder)}
    mechanisms = {}
    for name in motion["episodes"]:
        given = settings.get("episode", {}).get(name, {}).get("payload")
        payload = Payload(given["body"], given["mass"], tuple(given["com"])) if given else None
        mechanisms[name] = Mechanism.load(folder / "robot.xml", motion["joints"], payload=payload)
    return settings, mechanisms, motion
