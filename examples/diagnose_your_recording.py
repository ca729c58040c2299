"""Diagnose arrays: find the law that a model of a pushed table misses, and where it acts.

    python examples/diagnose_your_recording.py [--out diagnosis/table]

The arrays come from a simulated table with a locked wheel and dry friction at one foot, which the nominal
model does not contain. Replace them by your own. The command line equivalent is `trundle diagnose RECORDING
--out FOLDER`. In examples/diagnose_your_simulator.py the simulation under test is your own.
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
    """Logs of two instruments with separate sample times: shapes (n,), (n, 3), (n, 3), (m,), (m, 3)."""

    tracker_t: Floats
    table: Floats
    hand: Floats
    sensor_t: Floats
    wrench: Floats


def simulated_logs() -> list[Push]:
    """Return pushes as arrays: s, (m, m, rad), and (N, N, N m) in the axes of the hand. Replace this part."""
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
    """Return the columns of an episode: one row per time, NaN where an instrument has no sample."""
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


# What the arrays do not contain: the footprint, the sign of the reading, that it is raw (with the sensor's
# offset), the interval without contact, the noise of the instruments, and the held-out push.
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
    episodes = {f"push_{k}": columns(push) for k, push in enumerate(simulated_logs())}
    recording = trundle.Recording(METADATA, episodes)

    # Check units, signs, axes, clocks, tare, and whether there is enough motion.
    findings = [f"{found.severity}: {found.sentence}" for found in trundle.check(recording)]
    print("checked", *(findings or ["nothing found"]), sep="\n  ")

    # The nominal model is the paper's, a rigid body with one viscous wheel; `model=` sets another.
    # The verdict is "consistent", "reparameterised", "explained" or "unexplained".
    found = trundle.diagnose(recording)
    print(f"diagnosed: {found.verdict}")
    for effect in found.answer["missing"]:
        print(f"  {effect['effect']}, probability {effect['probability']:.2f}: {effect['statement']}")

    # Error metrics on the held-out push.
    held_out = found.answer["fit"]["held_out"]
    for when in ("before", "after"):
        metrics = held_out[when]
        print(
            f"held out, {when}: {metrics['position_rmse']:.4f} m in open loop, "
            f"{metrics['window_position_rmse']:.4f} m one second ahead (RMS)"
        )

    # The model with the named effects, for simulation, planning or the next diagnosis.
    folder = found.write(out)
    print(f"written: {', '.join(sorted(path.name for path in folder.iterdir()))}")
    for parameter in trundle.Model.read(folder / "model.toml").parameters:
        print(f"  {parameter['name']:34} {parameter['value']:9.4f} {parameter['unit']}")
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Diagnose arrays, and write a model and a report.")
    parser.add_argument("--out", type=Path, help="folder for the report, the model and the predictions")
    folder = parser.parse_args().out
    with tempfile.TemporaryDirectory() as scratch:
        main(folder or Path(scratch) / "diagnosis")
