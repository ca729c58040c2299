"""Latency of an online update (median and 95th percentile), and its distance from the fit of all pushes.

python benches/online.py --pushes 8 --tables 5

Pushes of 6 s, poses at 60 Hz, wrenches at 100 Hz. Times are those of a call from Python, including the
conversion of the columns. The first push, which is searched from several starts, is listed separately. The
preparation of a push (tare, contact, spikes of the poses) is part of each time and is also listed alone.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np

import trundle

TABLE = Path(__file__).parents[1] / "configs" / "objects" / "office_table.toml"
SCENARIO = """
format = "trundle-scenario/1"
name = "table"
object = "{table}"
held_out = 0
[[effect]]
kind = "viscous_wheel"
x = -0.5
y = -0.3
angle = 0.2
mu_x = 15.0
mu_y = 180.0
[sensor]
rate = 100.0
[random]
count = {pushes}
duration = 6.0
speed = 0.3
spin = 0.5
"""


def simulate_pushes(pushes: int, seed: int) -> trundle.Recording:
    """Simulate pushes of a table with a locked wheel."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scenario.toml"
        path.write_text(SCENARIO.format(table=TABLE, pushes=pushes), encoding="utf-8")
        return trundle.simulate(path, seed=seed)


def squared_distance(online: trundle.Online, recording: trundle.Recording) -> float:
    """Return the mean squared distance from the fit of all pushes, in standard deviations of that fit."""
    batch = {row["name"]: row for row in trundle.fit(recording).summary["parameters"] if row["identifiable"]}
    rows = [row for row in online.estimate() if row["name"] in batch and row["identifiable"]]
    return float(
        np.mean(
            [((row["mean"] - batch[row["name"]]["mean"]) / batch[row["name"]]["sd"]) ** 2 for row in rows]
        )
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pushes", type=int, default=8)
    parser.add_argument("--tables", type=int, default=5)
    args = parser.parse_args()
    first, later, chunks, prepared, distances = [], [], [], [], []
    for seed in range(args.tables):
        recording = simulate_pushes(args.pushes, seed)
        online, chunked = (trundle.Online(recording.metadata) for _ in range(2))
        for k, columns in enumerate(recording.episodes.values()):
            alone = trundle.Recording(recording.metadata, {"push": columns})
            start = perf_counter()
            trundle.prepare(alone)
            prepared.append(1e3 * (perf_counter() - start))
            start = perf_counter()
            online.update(columns)
            (later if k else first).append(1e3 * (perf_counter() - start))
            for rows in np.array_split(np.arange(len(columns["t"])), 6):
                start = perf_counter()
                chunked.extend({name: column[rows] for name, column in columns.items()})
                if k:
                    chunks.append(1e3 * (perf_counter() - start))
            chunked.update()
        distances.append(squared_distance(online, recording))
    parts = {"first push": first, "later pushes": later, "chunks of 1 s": chunks}
    parts["preparation"] = prepared
    for name, values in parts.items():
        print(f"{name:14} median {np.median(values):6.2f} ms   p95 {np.percentile(values, 95):6.2f} ms")
    print(
        f"squared distance from the fit of all pushes, per parameter: {np.mean(distances):.4f} "
        f"(maximum {max(distances):.4f})"
    )


if __name__ == "__main__":
    main()
