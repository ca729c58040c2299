"""Draw the figures of docs/real-recordings.md.

    python examples/real_pictures.py DATA docs/images

DATA contains `emps/` and `cmu-planar-push/` (sources: docs/real-recordings.md).
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from real_recordings import (
    MODELS,
    about_centroid,
    by_direction,
    emps,
    logs,
    missing_force,
    pushes,
    ripple,
    spectrum,
    with_held_out,
)

import trundle

GREY, VISCOUS, DRY = "0.35", "#d1495b", "#00798c"


def draw_emps(data: Path, out: Path) -> None:
    """Draw the held-out file in open loop, and the missing force after the diagnosis."""
    recording = emps(data)
    answer = trundle.diagnose(recording, MODELS / "rail_viscous.toml")
    held_out = next(e for e in answer.series["episodes"] if e["held_out"])
    missing = missing_force(recording, "episode_00", by_direction(recording))
    figure, axes = plt.subplots(2, 2, figsize=(11, 6.5), layout="constrained")
    axis = axes[0, 0]
    for key, colour, label in (
        ("before", VISCOUS, "viscous only"),
        ("after", DRY, "with named effects"),
    ):
        error = 1e3 * (np.array(held_out[key])[:, 0] - np.array(held_out["observed"])[:, 0])
        axis.plot(held_out["t"], error, color=colour, lw=1, label=label)
    axis.set(title="held-out file, open loop", xlabel="t, s", ylabel="error of position, mm")
    axis.legend(fontsize=8)
    axis = axes[0, 1]
    axis.plot(missing["t"], missing["missing"], color=GREY, lw=0.6)
    turns = np.flatnonzero(np.diff(np.sign(missing["v"])))
    axis.plot(missing["t"][turns], np.full(len(turns), -24.0), "^", color=DRY, ms=4, label="reversal")
    axis.set(title="missing force", xlabel="t, s", ylabel="N", xlim=(2, 12), ylim=(-26, 26))
    axis.legend(fontsize=8)
    for speed, colour in ((0.083, VISCOUS), (0.125, DRY)):
        x, force = ripple(missing, speed)
        cycles, power = spectrum(force, speed)
        axes[1, 0].plot(1e3 * x, force, color=colour, lw=1, label=f"{speed} m/s")
        axes[1, 1].plot(1e-3 * cycles, power / power.max(), color=colour, lw=1, label=f"{speed} m/s")
    axes[1, 0].set(
        title="missing force at constant speed, slow part removed", xlabel="position, mm", ylabel="N"
    )
    axes[1, 1].set(title="spectrum over position", xlabel="cycles per mm", xlim=(0, 0.8), yticks=[])
    axes[1, 1].axvline(0.4, color=GREY, ls=":", lw=1, label="2.5 mm")
    for axis in axes[1]:
        axis.legend(fontsize=8)
    save(figure, out / "real-emps.png")


def held_out_wrenches(recording: trundle.Recording) -> tuple[np.ndarray, dict[str, np.ndarray], np.ndarray]:
    """Return times, required wrenches by law and recorded wrenches of the held-out episodes, (n, 3), N."""
    corners = np.array(recording.metadata["object"]["footprint"])
    required: dict[str, np.ndarray] = {}
    for law, name in (("viscous", "drag_under_body"), ("dry", "friction_under_body")):
        series = trundle.diagnose(recording, MODELS / f"{name}.toml").series
        held_out: list[dict[str, Any]] = [
            e["wrench"] for e in series["episodes"] if e["held_out"] and e["wrench"]
        ]
        required[law] = np.concatenate([about_centroid(np.array(w["before"]), corners) for w in held_out])
    recorded = np.concatenate([about_centroid(np.array(w["recorded"]), corners) for w in held_out])
    return np.concatenate([w["t"] for w in held_out]), required, recorded


CHANNELS = ("force along x, N", "force along y, N", "moment / radius of gyration, N")


def draw_pushes(data: Path, out: Path) -> None:
    """Draw the required over the recorded wrench, for the held-out pushes of all sets."""
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.9), layout="constrained")
    for recording in pushes(data).values():
        _, required, recorded = held_out_wrenches(recording)
        for axis, k in zip(axes, range(3), strict=True):
            axis.plot(recorded[:, k], required["viscous"][:, k], "x", color=VISCOUS, ms=4, mew=0.8)
            axis.plot(recorded[:, k], required["dry"][:, k], "o", color=DRY, ms=3.5, alpha=0.8)
    for axis, name in zip(axes, CHANNELS, strict=True):
        axis.axline((0, 0), slope=1, color=GREY, lw=0.8)
        axis.set(title=name, xlabel="recorded", ylabel="required for the recorded motion")
    handles = [axes[0].plot([], [], "x", color=VISCOUS)[0], axes[0].plot([], [], "o", color=DRY)[0]]
    axes[0].legend(handles, ["viscous under the body", "dry under the body"], fontsize=8)
    figure.suptitle("held-out pushes of five sets", fontsize=11)
    save(figure, out / "real-pushes.png")


def draw_logs(data: Path, out: Path) -> None:
    """Draw the wrench along a held-out log."""
    t, required, recorded = held_out_wrenches(with_held_out(logs(data, earlier=False), "exp3_3"))
    figure, axes = plt.subplots(3, 1, figsize=(11, 6.5), sharex=True, layout="constrained")
    for axis, k in zip(axes, range(3), strict=True):
        axis.plot(t, recorded[:, k], "-", color=GREY, lw=1, marker=".", label="recorded")
        axis.plot(
            t, required["viscous"][:, k], "x", color=VISCOUS, ms=5, label="required, viscous under the body"
        )
        axis.plot(t, required["dry"][:, k], "o", color=DRY, ms=4, label="required, dry under the body")
        axis.set(ylabel=CHANNELS[k].replace(" / ", " /\n"))
    axes[0].legend(fontsize=8, ncols=3, loc="upper center", bbox_to_anchor=(0.5, 1.3))
    axes[-1].set(xlabel="t, s (log exp3_3, fitted to exp3_4 and exp4_1)")
    save(figure, out / "real-logs.png")


def save(figure: plt.Figure, path: Path) -> None:
    """Write a figure."""
    figure.savefig(path, dpi=75)
    plt.close(figure)
    print(path)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path, help="folder with emps/ and cmu-planar-push/")
    parser.add_argument("out", type=Path, help="output folder of the PNG files")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    for draw in (draw_emps, draw_pushes, draw_logs):
        draw(given.data, given.out)
