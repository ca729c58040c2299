"""From arrays to a diagnosis: which law the usual model of a pushed table leaves out, and where it acts.

    python examples/diagnose_your_recording.py [--out diagnosis/table]

Read it from top to bottom. The arrays are made here, by a simulated table with a locked wheel that also drags
a foot; the diagnosis is not told. Put your own in their place. `trundle diagnose RECORDING --out FOLDER` is
the command for it; in examples/diagnose_your_simulator.py the simulation under test is your own.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import trundle

Floats = NDArray[np.float64]

SCENARIO = Path(__file__).resolve().parents[1] / "configs/experiments/demo.toml"
PUSHES = 5


class Push(NamedTuple):
    """What two instruments logged, each on its own clock: shapes (n,), (n, 3), (n, 3), (m,), (m, 3)."""

    tracker_t: Floats
    table: Floats
    hand: Floats
    sensor_t: Floats
    wrench: Floats


def logged() -> list[Push]:
    """Return pushes as arrays: s, (m, m, rad), and (N, N, N m) in the hand's axes. The part to replace."""
    pushes = []
    for seen in list(trundle.simulate(SCENARIO).episodes.values())[:PUSHES]:
        tracked, read = np.isfinite(seen["object_x"]), np.isfinite(seen["force_x"])
        table, hand = (
            np.column_stack([seen[f"{body}_{axis}"][tracked] for axis in ("x", "y", "theta")])
            for body in ("object", "gripper")
        )
        wrench = np.column_stack([seen[name][read] for name in ("force_x", "force_y", "torque_z")])
        pushes.append(Push(seen["t"][tracked], table, hand, seen["t"][read], wrench))
    return pushes


def columns(push: Push) -> dict[str, Floats]:
    """Return the table of an episode: a row for each time, NaN where an instrument has no sample."""
    t = np.union1d(push.tracker_t, push.sensor_t)
    table = {"t": t}
    for names, times, values in (
        (("object_x", "object_y", "object_theta"), push.tracker_t, push.table),
        (("gripper_x", "gripper_y", "gripper_theta"), push.tracker_t, push.hand),
        (("force_x", "force_y", "torque_z"), push.sensor_t, push.wrench),
    ):
        for name, column in zip(names, values.T, strict=True):
            table[name] = np.full(len(t), np.nan)
            table[name][np.searchsorted(t, times)] = column
    return table


# What no array tells: the outline, what the reading's sign means, that the sensor's zero is still in it, when
# nothing was touched yet, how good the instruments are, and which push is never fitted.
METADATA = {
    "format": "trundle-recording/1",
    "name": "a table",
    "object": {
        "footprint": [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]],
        "support": [[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]],
    },
    "wrench": {"frame": "sensor", "sign": "on_object", "raw": True, "precontact": [0.0, 0.4]},
    "noise": {"pose": [5e-4, 5e-4, 1.75e-3], "force": 0.4, "torque": 0.05},
    "split": {"held_out": [f"push_{PUSHES - 1}"]},
}


def main(out: Path) -> trundle.Diagnosis:
    episodes = {f"push_{k}": columns(push) for k, push in enumerate(logged())}
    recording = trundle.Recording(METADATA, episodes)

    # Before any physics: units, signs, axes, clocks, tare, enough motion.
    findings = [f"{found['severity']}: {found['sentence']}" for found in trundle.check(recording)]
    print("checked", *(findings or ["nothing found"]), sep="\n  ")

    # The simulation under test is the paper's, a rigid body with one viscous wheel; `model=` gives another.
    # The verdict is "consistent", "reparameterised", "explained" or "unexplained".
    found = trundle.diagnose(recording)
    print(f"diagnosed: {found.verdict}")
    for effect in found.answer["missing"]:
        print(f"  {effect['effect']}, probability {effect['probability']:.2f}: {effect['statement']}")

    # Effects are believed for what they predict of the push that was held out, from its start to its end.
    held_out = found.answer["fit"]["held_out"]
    for when in ("before", "after"):
        figures = held_out[when]
        print(
            f"held out, {when} them: {figures['position_rmse']:.4f} m in open loop, "
            f"{figures['window_position_rmse']:.4f} m from one second to the next (rms)"
        )

    # The richer model is one to simulate, to plan on, or to start the next diagnosis from.
    folder = found.write(out)
    print(f"written: {', '.join(sorted(path.name for path in folder.iterdir()))}")
    for parameter in trundle.Model.read(folder / "model.toml").parameters:
        print(f"  {parameter['name']:34} {parameter['value']:9.4f} {parameter['unit']}")
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="From arrays to a diagnosis, a model and a report.")
    parser.add_argument("--out", type=Path, help="folder for the report, the model and the predictions")
    folder = parser.parse_args().out
    with tempfile.TemporaryDirectory() as scratch:
        main(folder or Path(scratch) / "diagnosis")
