"""From a logger's CSV files to a model with intervals, and a push that it had not seen, predicted.

    python examples/fit_your_recording.py [--out runs/fit]

Read it from top to bottom. The logs are made here, by an environment, so that the truth is known at the end.
Put your own in their place, with a map that names your columns, units and signs (docs/import.md). `trundle
import`, `trundle check`, `trundle fit` and `trundle predict` do the same on the command line.
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

PUSHES, SECONDS, HELD = 4, 6.0, 0.6
"""How many, how long, and how long the hand keeps a velocity, s."""

# What the columns are; under [recording], what no log tells: the table's outline, what the reading's sign is,
# when nothing was touched yet, how good the instruments are, and which push the fit is not to see.
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


def logged(env: gymnasium.Env[Any, Any], folder: Path) -> None:
    """Push with a velocity-driven hand, and write a CSV file for each push, as a logger might."""
    source: Any = env.unwrapped
    source.start_recording()
    rng = np.random.default_rng(0)
    for number in range(PUSHES):
        options = {"start": (0.0, 0.0, 1.5 * number), "same_object": number > 0}
        env.reset(seed=3 if number == 0 else None, options=options)
        rows = [source.take_rows()]
        for step in range(round(SECONDS / source.control)):
            if step % round(HELD / source.control) == 0:
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
    logged(env, out / "logs")
    (out / "map.toml").write_text(MAP)

    # Import. Nothing is repaired silently: what was left out on the way is told.
    imported = read(out / "logs", "csv", out / "map.toml")
    recording = trundle.Recording(imported.metadata, imported.episodes)
    recording.write(out / "recording")
    print(f"imported {', '.join(recording.episodes)}", *imported.remarks, sep="\n  ")

    # Check, before any physics: units, signs, axes, clocks, tare, enough motion.
    findings = [f"{found['severity']}: {found['sentence']}" for found in trundle.check(recording)]
    print("checked", *(findings or ["nothing found"]), sep="\n  ")

    # Fit the paper's model, a rigid body with one viscous wheel, to all pushes but the one held out.
    fit = trundle.fit(recording)
    fit.model.write(out / "model.toml")
    print("fitted, with intervals of 90 %")
    for p in fit.summary["parameters"]:
        if p["identifiable"]:
            ends = "{:.4f} to {:.4f}".format(*(p["mean"] + side * 1.645 * p["sd"] for side in (-1, 1)))
            print(f"  {p['name']:20} {p['mean']:9.4f} {p['unit']:6} {ends}")
        else:
            print(f"  {p['name']:20} not held by these pushes")

    # Predict the push held out, in open loop: the model is told where it begins and what the sensor read. The
    # sensor's zero is known to some hundredths of a newton; a table that turns about its wheel adds that up.
    seen = trundle.prepare(recording)["episode_03"]
    t, still = seen["wrench_t"], seen["pose_t"] < 0.4
    first = seen["pose"][still].mean(axis=0)
    poses, _ = fit.model.rollout(first, [0.0] * 3, t, seen["on_object"], contact=seen["contact"])
    off = [np.interp(seen["pose_t"], t, poses[:, k]) - seen["pose"][:, k] for k in (0, 1)]
    ahead = fit.summary["held_out"]["window_position_rmse"]
    print(f"predicted the push held out, {t[-1] - seen['contact']:.1f} s")
    print(f"  the table moved {np.hypot(*(seen['pose'][-1] - first)[:2]):.3f} m")
    print(f"  off at the end {np.hypot(*off)[-1]:.3f} m; from one second to the next {ahead:.4f} m (rms)")

    source: Any = env.unwrapped
    truth = source.hidden_model()
    print("the truth; a wheel turned by a quarter, with its two drags exchanged, is the same wheel")
    print(f"  {truth['body']['mass']} kg,", ", ".join(f"{k} {v}" for k, v in truth["effect"][0].items()))
    return fit


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="From a logger's CSV files to a model, and a prediction.")
    parser.add_argument("--out", type=Path, help="folder to keep logs, map, recording and model in")
    folder = parser.parse_args().out
    with tempfile.TemporaryDirectory() as scratch:
        main(folder or Path(scratch))
