"""Fit a model to a logger's CSV files, and predict a held-out push.

    python examples/fit_your_recording.py [--out runs/fit]

An environment writes the logs, so that the true model is known. Replace them by your own, with a map of your
columns, units and signs (docs/import.md). The command line equivalents are `trundle import`, `trundle check`,
`trundle fit` and `trundle predict`.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

import trundle
from trundle.importers import read

PUSHES, PUSH_DURATION_S, VELOCITY_DURATION_S = 4, 6.0, 0.6
"""Number and duration of the pushes, and how long the hand keeps a velocity, s."""

# Meaning of the columns. [recording] contains what logs do not: the footprint, the sign of the reading, the
# interval without contact, the noise of the instruments, and the held-out push.
MAP = """
name = "table"
delimiter = ";"
time = {name = "stamp_ms", unit = "ms"}

[columns]
object_x = {name = "table_x", unit = "mm"}
object_y = {name = "table_y", unit = "mm"}
object_theta = {name = "table_yaw", unit = "deg"}
gripper_x = {name = "hand_x", unit = "mm"}
gripper_y = {name = "hand_y", unit = "mm"}
gripper_theta = {name = "hand_yaw", unit = "deg"}
force_x = "fx"
force_y = "fy"
torque_z = {name = "tz", unit = "N mm"}

[recording.object]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]

[recording.wrench]
frame = "sensor"
sign = "on_object"
raw = true
precontact = [0.0, 0.4]

[recording.noise]
pose = [0.0005, 0.0005, 0.00175]
force = 0.4
torque = 0.05

[recording.split]
held_out = ["episode_03"]
"""


def write_logs(env: gymnasium.Env[Any, Any], folder: Path) -> None:
    """Push with a velocity-controlled hand, and write a CSV file for each push, like a logger."""
    source: Any = env.unwrapped
    source.start_recording()
    rng = np.random.default_rng(0)
    for number in range(PUSHES):
        options = {"start": (0.0, 0.0, 1.5 * number), "same_object": number > 0}
        env.reset(seed=3 if number == 0 else None, options=options)
        rows = [source.take_rows()]
        for step in range(round(PUSH_DURATION_S / source.control)):
            if step % round(VELOCITY_DURATION_S / source.control) == 0:
                velocity = rng.uniform(-1.0, 1.0, 3).astype(np.float32)
            *_, terminated, truncated, _ = env.step(velocity)
            rows.append(source.take_rows())
            if terminated or truncated:
                break
        seen = {key: np.concatenate([row[key] for row in rows]) for key in rows[0]}
        table = {"stamp_ms": 1_750_000_000_000 + 60_000 * number + 1e3 * seen["t"]}
        for ours, body in (("table", "object"), ("hand", "gripper")):
            table |= {f"{ours}_{axis}": 1e3 * seen[f"{body}_{axis}"] for axis in "xy"}
            table[f"{ours}_yaw"] = np.degrees(seen[f"{body}_theta"])
        table |= {"fx": seen["force_x"], "fy": seen["force_y"], "tz": 1e3 * seen["torque_z"]}
        cells = np.char.replace(np.char.mod("%.3f", np.column_stack(list(table.values()))), "nan", "")
        lines = [";".join(row) for row in [list(table), *cells]]
        (folder / f"push_{number}.csv").write_text("\n".join(lines) + "\n")


def main(out: Path) -> trundle.Fit:
    env = gymnasium.make("trundle/LockedWheel-v0", action="velocity")
    (out / "logs").mkdir(parents=True, exist_ok=True)
    write_logs(env, out / "logs")
    (out / "map.toml").write_text(MAP)

    # Import. Remarks list omitted samples.
    imported = read(out / "logs", "csv", out / "map.toml")
    recording = trundle.Recording(imported.metadata, imported.episodes)
    recording.write(out / "recording")
    print(f"imported {', '.join(recording.episodes)}", *imported.remarks, sep="\n  ")

    # Check units, signs, axes, clocks, tare, and whether there is enough motion.
    findings = [f"{found.severity}: {found.sentence}" for found in trundle.check(recording)]
    print("checked", *(findings or ["nothing found"]), sep="\n  ")

    # Fit the paper's model, a rigid body with one viscous wheel, to the training pushes.
    fit = trundle.fit(recording)
    fit.model.write(out / "model.toml")
    print("fitted, with 90 % intervals")
    for p in fit.summary["parameters"]:
        if p["identifiable"]:
            ends = f"{p['low']:.4f} to {p['high']:.4f}"
            print(f"  {p['name']:20} {p['mean']:9.4f} {p['unit']:6} {ends}")
        else:
            print(f"  {p['name']:20} not identifiable from these data")

    # Predict the held-out push in open loop, from its first pose and the recorded wrench. The tare error of
    # some hundredths of a newton accumulates as the table turns about its wheel.
    seen = trundle.prepare(recording)["episode_03"]
    t, still = seen["wrench_t"], seen["pose_t"] < 0.4
    first = seen["pose"][still].mean(axis=0)
    poses, _ = fit.model.rollout(first, [0.0] * 3, t, seen["on_object"], contact=seen["contact"])
    off = [np.interp(seen["pose_t"], t, poses[:, k]) - seen["pose"][:, k] for k in (0, 1)]
    ahead = fit.summary["held_out"]["window_position_rmse"]
    print(f"prediction of the held-out push, {t[-1] - seen['contact']:.1f} s")
    print(f"  the table moved {np.hypot(*(seen['pose'][-1] - first)[:2]):.3f} m")
    print(f"  error at the end {np.hypot(*off)[-1]:.3f} m; one second ahead {ahead:.4f} m (RMS)")

    source: Any = env.unwrapped
    truth = source.hidden_model()
    print("true model (a wheel rotated by 90° with exchanged drags is the same wheel)")
    print(f"  {truth['body']['mass']} kg,", ", ".join(f"{k} {v}" for k, v in truth["effect"][0].items()))
    return fit


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Fit a model to CSV files, and predict a push.")
    parser.add_argument("--out", type=Path, help="output folder for logs, map, recording and model")
    folder = parser.parse_args().out
    with tempfile.TemporaryDirectory() as scratch:
        main(folder or Path(scratch))
