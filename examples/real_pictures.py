"""The pictures of docs/real-recordings.md.

    python examples/real_pictures.py DATA docs/images

DATA holds `emps/` and `cmu-planar-push/` (docs/real-recordings.md says where they come from).
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
    holding_out,
    logs,
    missing_force,
    pushes,
    ripple,
    spectrum,
)

import trundle

GREY, VISCOUS, DRY = "0.35", "#d1495b", "#00798c"


def draw_emps(data: Path, out: Path) -> None:
    """Draw the held-out file in open loop, and what remains after the diagnosis."""
    recording = emps(data)
    answer = trundle.diagnose(recording, MODELS / "rail_viscous.toml")
    held_out = next(e for e in answer.series["episodes"] if e["held_out"])
    left = missing_force(recording, "episode_00", by_direction(recording))
    figure, axes = plt.subplots(2, 2, figsize=(11, 6.5), layout="constrained")
    axis = axes[0, 0]
    for key, colour, label in (
        ("before", VISCOUS, "viscous alone"),
        ("after", DRY, "with the effects found"),
    ):
        error = 1e3 * (np.array(held_out[key])[:, 0] - np.array(held_out["observed"])[:, 0])
        axis.plot(held_out["t"], error, color=colour, lw=1, label=label)
    axis.set(title="held-out file, open loop from force alone", xlabel="t, s", ylabel="error of position, mm")
    axis.legend(fontsize=8)
    axis = axes[0, 1]
    axis.plot(left["t"], left["missing"], color=GREY, lw=0.6)
    turns = np.flatnonzero(np.diff(np.sign(left["v"])))
    axis.plot(left["t"][turns], np.full(len(turns), -24.0), "^", color=DRY, ms=4, label="reversal")
    axis.set(title="force still missing", xlabel="t, s", ylabel="N", xlim=(2, 12), ylim=(-26, 26))
    axis.legend(fontsize=8)
    for speed, colour in ((0.083, VISCOUS), (0.125, DRY)):
        x, force = ripple(left, speed)
        cycles, power = spectrum(force, speed)
        axes[1, 0].plot(1e3 * x, force, color=colour, lw=1, label=f"{speed} m/s")
        axes[1, 1].plot(1e-3 * cycles, power / power.max(), color=colour, lw=1, label=f"{speed} m/s")
    axes[1, 0].set(
        title="force still missing at constant speed, slow part removed", xlabel="position, mm", ylabel="N"
    )
    axes[1, 1].set(title="its spectrum over position", xlabel="cycles per mm", xlim=(0, 0.8), yticks=[])
    axes[1, 1].axvline(0.4, color=GREY, ls=":", lw=1, label="2.5 mm")
    for axis in axes[1]:
        axis.legend(fontsize=8)
    save(figure, out / "real-emps.png")


def compared(recording: trundle.Recording) -> tuple[np.ndarray, dict[str, np.ndarray], np.ndarray]:
    """Return times, wrenches needed by law and recorded wrenches of the held-out episodes, (n, 3), in N."""
    corners = np.array(recording.metadata["object"]["footprint"])
    needed: dict[str, np.ndarray] = {}
    for law, name in (("viscous", "drag_under_body"), ("dry", "friction_under_body")):
        series = trundle.diagnose(recording, MODELS / f"{name}.toml").series
        held_out: list[dict[str, Any]] = [
            e["wrench"] for e in series["episodes"] if e["held_out"] and e["wrench"]
        ]
        needed[law] = np.concatenate([about_centroid(np.array(w["before"]), corners) for w in held_out])
    recorded = np.concatenate([about_centroid(np.array(w["recorded"]), corners) for w in held_out])
    return np.concatenate([w["t"] for w in held_out]), needed, recorded


CHANNELS = ("force along x, N", "force along y, N", "moment / radius of gyration, N")


def draw_pushes(data: Path, out: Path) -> None:
    """Draw the wrench needed over the one recorded, for the held-out pushes of all sets."""
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.9), layout="constrained")
    for recording in pushes(data).values():
        _, needed, recorded = compared(recording)
        for axis, k in zip(axes, range(3), strict=True):
            axis.plot(recorded[:, k], needed["viscous"][:, k], "x", color=VISCOUS, ms=4, mew=0.8)
            axis.plot(recorded[:, k], needed["dry"][:, k], "o", color=DRY, ms=3.5, alpha=0.8)
    for axis, name in zip(axes, CHANNELS, strict=True):
        axis.axline((0, 0), slope=1, color=GREY, lw=0.8)
        axis.set(title=name, xlabel="recorded", ylabel="needed for the seen motion")
    handles = [axes[0].plot([], [], "x", color=VISCOUS)[0], axes[0].plot([], [], "o", color=DRY)[0]]
    axes[0].legend(handles, ["viscous under the body", "dry under the body"], fontsize=8)
    figure.suptitle("held-out pushes of five sets", fontsize=11)
    save(figure, out / "real-pushes.png")


def draw_logs(data: Path, out: Path) -> None:
    """Draw the wrench along a log that was held out."""
    t, needed, recorded = compared(holding_out(logs(data, earlier=False), "exp3_3"))
    figure, axes = plt.subplots(3, 1, figsize=(11, 6.5), sharex=True, layout="constrained")
    for axis, k in zip(axes, range(3), strict=True):
        axis.plot(t, recorded[:, k], "-", color=GREY, lw=1, marker=".", label="recorded")
        axis.plot(
            t, needed["viscous"][:, k], "x", color=VISCOUS, ms=5, label="needed, viscous under the body"
        )
        axis.plot(t, needed["dry"][:, k], "o", color=DRY, ms=4, label="needed, dry under the body")
        axis.set(ylabel=CHANNELS[k].replace(" / ", " /\n"))
    axes[0].legend(fontsize=8, ncols=3, loc="upper center", bbox_to_anchor=(0.5, 1.3))
    axes[-1].set(xlabel="t, s (log exp3_3, fitted to exp3_4 and exp4_1)")
    save(figure, out / "real-logs.png")


def save(figure: plt.Figure, path: Path) -> None:
    """Write a picture."""
    figure.savefig(path, dpi=75)
    plt.close(figure)
    print(path)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path, help="folder that holds emps/ and cmu-planar-push/")
    parser.add_argument("out", type=Path, help="folder to write PNG files to")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    for draw in (draw_emps, draw_pushes, draw_logs):
        draw(given.data, given.out)
