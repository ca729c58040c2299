"""Where the time of a diagnosis goes, what memory it takes, and how both grow with the recording.

python benches/diagnosis.py --pushes 2 4 8 16

A table with a wheel that also rubs somewhere, which is to be found: pushes of 6 s, poses at 60 Hz, wrenches
at 100 Hz, and one more push that is held out. Each recording is diagnosed in a process of its own. Times are
of all cores (CPU) by the stage that the diagnosis reports; single fits belong to the stage around them, the
screen to the simulation under test, rivals and the page to the figures. Memory: the most that the process
had, and what it had before it diagnosed.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter, process_time
from typing import NamedTuple

import numpy as np

import trundle
from trundle.report import render

TABLE = Path(__file__).parents[1] / "configs" / "objects" / "office_table.toml"
SCENARIO = """
format = "trundle-scenario/1"
name = "table"
object = "{table}"
held_out = 1
[[effect]]
kind = "viscous_wheel"
x = -0.5
y = -0.3
angle = 0.2
mu_x = 15.0
mu_y = 180.0
[[effect]]
kind = "coulomb_friction"
x = 0.4
y = 0.2
force = 12.0
[sensor]
rate = 100.0
[random]
count = {pushes}
duration = 6.0
speed = 0.3
spin = 0.5
"""
INNER = ("fit", "profile")
"""Reports of what happens within a stage."""
MIB = 1024 if sys.platform == "linux" else 1024**2
"""Of `ru_maxrss` in a MiB."""


class Stages:
    """CPU seconds by stage."""

    def __init__(self) -> None:
        self.stage, self.since = "reading", process_time()
        self.seconds: dict[str, float] = {}

    def __call__(self, what: str, share: float = 0.0) -> None:
        """Count what went by to the stage that ends here, if one does."""
        if what not in (self.stage, *INNER):
            now = process_time()
            self.seconds[self.stage] = self.seconds.get(self.stage, 0.0) + now - self.since
            self.stage, self.since = what, now


class Measured(NamedTuple):
    """What one diagnosis took: CPU seconds by stage, of writing the page, seconds by the clock, MiB."""

    stages: dict[str, float]
    page: float
    clock: float
    before: float
    peak: float
    answer: str


def recorded(pushes: int) -> trundle.Recording:
    """Return pushes of the table, and one that is held out."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scenario.toml"
        path.write_text(SCENARIO.format(table=TABLE, pushes=pushes + 1), encoding="utf-8")
        return trundle.simulate(path, seed=0)


def memory() -> float:
    """Return the most memory that this process has had, MiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / MIB


def measured(pushes: int) -> Measured:
    """Diagnose a recording."""
    recording, before = recorded(pushes), memory()
    began, stages = perf_counter(), Stages()
    found = trundle.diagnose(recording, progress=stages)
    stages("end")
    clock, page = perf_counter() - began, process_time()
    render(found.answer, found.series)
    page = process_time() - page
    answer = " ".join([found.verdict, *found.missing])
    return Measured(stages.seconds, page, clock, before, memory(), answer)


def apart(pushes: int) -> Measured:
    """Return the same from a process of its own, whose memory is its own."""
    command = [sys.executable, __file__, "--one", str(pushes)]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE)
    return Measured(**json.loads(done.stdout))


def power(sizes: list[int], values: list[float]) -> float:
    """Return the exponent by which values grow with sizes: the slope of their logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(values), 1)[0])


def show(sizes: list[int], found: list[Measured]) -> None:
    """Print stages down, recordings across."""
    stages = list(dict.fromkeys(stage for one in found for stage in one.stages))
    totals = [sum(one.stages.values()) for one in found]
    line("CPU seconds, pushes fitted:", sizes, "9d")
    for stage in stages:
        line(stage, [one.stages.get(stage, 0.0) for one in found])
    line("  of these, the page", [one.page for one in found])
    line("all", totals)
    line("all, for each push", [total / size for total, size in zip(totals, sizes, strict=True)])
    line("seconds by the clock", [one.clock for one in found])
    line("MiB before", [one.before for one in found], "9.1f")
    line("MiB at most", [one.peak for one in found], "9.1f")
    if len(sizes) > 1:
        print(f"CPU seconds grow as pushes to the power of {power(sizes, totals):.2f}")
    for size, one in zip(sizes, found, strict=True):
        print(f"{size} pushes: {one.answer}")


def line(name: str, values: Sequence[float], form: str = "9.2f") -> None:
    """Print a line of the table."""
    print(f"{name:32}" + "".join(format(value, form) for value in values))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--pushes", type=int, nargs="+", default=[2, 4, 8, 16])
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.one is None:
        show(args.pushes, [apart(pushes) for pushes in args.pushes])
    else:
        print(json.dumps(measured(args.one)._asdict()))


if __name__ == "__main__":
    main()
