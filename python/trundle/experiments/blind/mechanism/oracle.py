"""Effort misfit of the refitted nominal model, from which materiality is decided.

Recorded efforts and the model's efforts pass through the filters of a diagnosis's figures, so that what the
filters remove counts for neither.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import tomllib
from scipy.optimize import lsq_linear

from trundle import _native
from trundle.experiments.sampling import Floats
from trundle.mechanism import Mechanism, Payload

__all__ = ["effort_misfits"]

SPREAD = {"mass": 0.3, "armature": 1.0, "damping": 1.0}
"""Prior standard deviations of the nominal parameters, relative to the given values."""
RELATIVE_NOISE = 3e-3
"""Effort noise against which the prior is weighed, relative to the range of the effort."""
HALF_WIDTH = 4.0
"""Half width of the Gaussian filter, standard deviations."""
SD_OF_ONE_HERTZ = np.sqrt(np.log(2.0)) / (2.0 * np.pi)
"""Standard deviation of a Gaussian filter with a cut-off (-3 dB) of 1 Hz, s."""


def effort_misfits(folder: Path) -> tuple[float, float]:
    """Return the effort misfits of the refitted nominal model, relative to the efforts' ranges in training.

    The free parameters and the timing of the efforts within half a sample are fitted by least squares to the
    training episodes, with the format's prior. For targets without efforts, the effort is the controller's,
    of known stiffness and damping or of free ones.

    Returns
    -------
    tuple of two floats
        Of the training and of the held-out episodes.
    """
    settings, mechanisms, motion = load_recording(folder)
    names = columns_of(settings, motion)
    parts = {
        name: episode_rows(folder, name, settings, mechanisms[name], motion, names) for name in mechanisms
    }
    held = set(settings["split"]["held_out"])
    train, test = ([parts[name] for name in parts if (name in held) is wanted] for wanted in (False, True))
    limits = np.array([part[2] for part in train])
    scale = limits[:, 1].max(axis=0) - limits[:, 0].min(axis=0) + 1e-12
    sd = [prior_sd(one, settings, mechanisms) for one in names]
    values = fitted(train, scale, sd, [bounds_of(one, settings, folder) for one in names])

    def misfit(some: Sequence[tuple[Floats, Floats, Floats]]) -> float:
        residual = np.concatenate([y - a @ values for y, a, _ in some])
        return float(np.sqrt(np.mean((residual / scale) ** 2)))

    return misfit(train), misfit(test)


def fitted(
    parts: Sequence[tuple[Floats, Floats, Floats]],
    scale: Floats,
    sd: Sequence[float],
    bounds: Sequence[tuple[float, float]],
) -> Any:
    """Return the most probable values within bounds, under a normal prior around zero."""
    y, a = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
    rows = (a / scale[:, None] / RELATIVE_NOISE).reshape(-1, a.shape[2])
    lhs = np.vstack([rows, np.diag(1.0 / np.asarray(sd))])
    rhs = np.concatenate([(y / scale / RELATIVE_NOISE).ravel(), np.zeros(len(sd))])
    size = np.maximum(np.abs(lhs).max(axis=0), 1e-300)
    q, r = np.linalg.qr(lhs / size)
    limits = np.array(bounds).T * size
    return lsq_linear(r, q.T @ rhs, limits, method="bvls").x / size


def has_free_stiffness(settings: Mapping[str, Any]) -> bool:
    """Return whether targets drive joints with an unknown stiffness."""
    return "target" in settings and bool(settings["target"]["stiffness"] == "free")


def columns_of(settings: Mapping[str, Any], motion: Mapping[str, Any]) -> list[str]:
    """Return the names of the fitted parameters."""
    extra = ["timing", "compliance", "drive_damping"] if has_free_stiffness(settings) else ["timing"]
    return [
        *settings["mechanism"]["free"],
        *(f"{kind}:{joint}" for kind in extra for joint in motion["joints"]),
    ]


def prior_sd(name: str, settings: Mapping[str, Any], mechanisms: Mapping[str, Mechanism]) -> float:
    """Return the standard deviation of the prior of a parameter."""
    kind, place = name.split(":")
    if kind not in SPREAD or has_free_stiffness(settings):
        return np.inf
    first = next(iter(mechanisms.values()))
    if kind == "mass":
        return SPREAD[kind] * float(first.masses[place])
    return SPREAD[kind] * float(getattr(first, kind)[first.joints.index(place)])


def bounds_of(name: str, settings: Mapping[str, Any], folder: Path) -> tuple[float, float]:
    """Return the bounds of a parameter: timing is within half a sample, and no later than a held command."""
    if not name.startswith("timing:"):
        return -np.inf, np.inf
    t = read_table(next(iter(sorted(folder.glob("*.csv")))))["t"]
    half = 0.5 * float(np.median(np.diff(t)))
    return -half, 1e-12 if is_held(settings) else half


def is_held(settings: Mapping[str, Any]) -> bool:
    """Return whether efforts or targets are commands, which are held until the next one."""
    return "target" in settings or bool(settings["effort"]["source"] == "commanded")


def episode_rows(
    folder: Path,
    name: str,
    settings: Mapping[str, Any],
    mechanism: Mechanism,
    motion: Mapping[str, Any],
    names: Sequence[str],
) -> tuple[Floats, Floats, Floats]:
    """Return filtered efforts less the given model's, (T, n), and the columns of the parameters, (T, n, p).

    The last array has the smallest and the largest effort, (2, n).
    """
    one, joints = motion["episodes"][name], motion["joints"]
    found = mechanism.regressors(one["q"], one["v"], one["a"], derivatives=False)
    needed = found.effort - found.friction
    table = read_table(folder / f"{name}.csv")
    t, dt = one["t"], float(np.median(np.diff(one["t"])))
    sd = SD_OF_ONE_HERTZ / motion["bandwidth"] / np.sqrt(2.0)
    key = "target" if "target" in settings else "effort"
    seen = np.column_stack([means(table["t"], table[f"{key}_{j}"], t, dt, is_held(settings)) for j in joints])
    if key == "target":
        raw = np.column_stack([means(table["t"], table[f"q_{j}"], t, dt, held=False) for j in joints])
        seen = seen - raw
    seen = flat(seen, sd / dt)
    if key == "effort":
        effort = seen * settings["effort"].get("gain", 1.0)
    elif has_free_stiffness(settings):
        effort = seen
    else:
        table_of = settings["target"]
        kp, kd = (np.array([table_of[k][joint] for joint in joints]) for k in ("stiffness", "damping"))
        effort = kp * seen - kd * one["v"]
    columns = np.zeros((*needed.shape, len(names)))
    for k, parameter in enumerate(names):
        kind, place = parameter.split(":")
        if kind == "mass":
            columns[:, :, k] = found.mass[place]
            continue
        j = joints.index(place)
        sources = {
            "armature": one["a"], "damping": one["v"], "drive_damping": one["v"], "compliance": needed,
            "timing": np.gradient(effort, dt, axis=0),
        }  # fmt: skip
        columns[:, j, k] = sources[kind][:, j]
    right = effort if has_free_stiffness(settings) else effort - needed
    ends = 3 * int(HALF_WIDTH * sd / dt)
    inner = slice(ends, max(len(t) - ends, ends))
    limits = np.array([effort.min(axis=0), effort.max(axis=0)])
    return gaussian(right, sd / dt)[inner], gaussian(columns, sd / dt)[inner], limits


def read_table(path: Path) -> dict[str, Floats]:
    """Return the columns of a table by name."""
    names = path.read_text(encoding="utf-8").split("\n", 1)[0].split(",")
    return dict(zip(names, np.loadtxt(path, delimiter=",", skiprows=1, unpack=True), strict=True))


def means(t: Floats, values: Floats, at: Floats, dt: float, held: bool) -> Any:
    """Return means over intervals of `dt` around the times `at`, of held samples or of interpolated ones."""
    steps = np.diff(t)
    slopes = np.append(np.zeros(len(steps)) if held else np.diff(values) / steps, 0.0)
    pieces = values[:-1] * steps + 0.5 * slopes[:-1] * steps**2
    before = np.concatenate([[0.0], np.cumsum(pieces)])

    def integral(x: Floats) -> Any:
        k = np.clip(np.searchsorted(t, x, side="right") - 1, 0, len(t) - 1)
        d = x - t[k]
        return before[k] + values[k] * d + 0.5 * np.where(d > 0, slopes[k], 0.0) * d**2

    return (integral(at + 0.5 * dt) - integral(at - 0.5 * dt)) / dt


def gaussian(values: Floats, sd: float) -> Any:
    """Return values after a Gaussian filter along the first axis; `sd` is in samples."""
    half = int(np.ceil(HALF_WIDTH * sd))
    weights = np.exp(-0.5 * (np.arange(-half, half + 1) / sd) ** 2)
    flattened = values.reshape(len(values), -1)
    padded = np.pad(flattened, ((half, half), (0, 0)), mode="edge")
    found = np.apply_along_axis(np.convolve, 0, padded, weights / weights.sum(), mode="valid")
    return found.reshape(values.shape)


def flat(values: Floats, sd: float) -> Any:
    """Return values after the motion's first filter: a Gaussian one, applied again to what it removes."""
    return gaussian(values, sd) + gaussian(values - gaussian(values, sd), sd)


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
