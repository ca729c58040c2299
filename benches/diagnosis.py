"""CPU time and memory of a diagnosis, by stage and by length of the recording.

python benches/diagnosis.py --pushes 2 4 8 16

The recording shows a table with a wheel and dry friction at one point, in pushes of 6 s with poses at 60 Hz
and wrenches at 100 Hz; one more push is held out. Each recording is diagnosed in a separate process. CPU
times are those of all cores, by the stage that the diagnosis reports. Single fits count in the enclosing
stage, the screen in the simulation under test, competing models and the report in the error metrics. Memory
is the peak of the process, and its peak before the diagnosis.
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
NESTED_REPORTS = ("fit", "profile")
"""Progress reports within a stage."""
RSS_UNITS_PER_MIB = 1024 if sys.platform == "linux" else 1024**2
"""Units of `ru_maxrss` per MiB."""


class Stages:
    """Progress callback that adds up CPU seconds by stage."""

    def __init__(self) -> None:
        self.stage, self.since = "reading", process_time()
        self.seconds: dict[str, float] = {}

    def __call__(self, what: str, share: float = 0.0) -> None:
        """Add the elapsed CPU time to the last stage if a new one starts."""
        if what not in (self.stage, *NESTED_REPORTS):
            now = process_time()
            self.seconds[self.stage] = self.seconds.get(self.stage, 0.0) + now - self.since
            self.stage, self.since = what, now


class Cost(NamedTuple):
    """Cost of a diagnosis: CPU s by stage and of the report, wall time in s, MiB before and at the peak."""

    stages: dict[str, float]
    page: float
    clock: float
    before: float
    peak: float
    answer: str


def simulate_pushes(pushes: int) -> trundle.Recording:
    """Simulate pushes of the table, and one more that is held out."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scenario.toml"
        path.write_text(SCENARIO.format(table=TABLE, pushes=pushes + 1), encoding="utf-8")
        return trundle.simulate(path, seed=0)


def peak_memory_mib() -> float:
    """Return the peak memory of this process, MiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / RSS_UNITS_PER_MIB


def measure(pushes: int) -> Cost:
    """Diagnose a recording of so many pushes, and measure the cost."""
    recording, before = simulate_pushes(pushes), peak_memory_mib()
    start, stages = perf_counter(), Stages()
    diagnosis = trundle.diagnose(recording, progress=stages)
    stages("end")
    clock, page = perf_counter() - start, process_time()
    render(diagnosis.answer, diagnosis.series)
    page = process_time() - page
    answer = " ".join([diagnosis.verdict, *diagnosis.missing])
    return Cost(stages.seconds, page, clock, before, peak_memory_mib(), answer)


def measure_in_subprocess(pushes: int) -> Cost:
    """Return the same from a separate process, so that its memory is not shared."""
    command = [sys.executable, __file__, "--one", str(pushes)]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE)
    return Cost(**json.loads(done.stdout))


def growth_exponent(sizes: list[int], values: list[float]) -> float:
    """Return the exponent with which values grow with sizes: the slope of their logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(values), 1)[0])


def print_table(sizes: list[int], costs: list[Cost]) -> None:
    """Print a table with a row for each stage and a column for each recording."""
    stages = list(dict.fromkeys(stage for cost in costs for stage in cost.stages))
    totals = [sum(cost.stages.values()) for cost in costs]
    print_row("CPU seconds, pushes fitted:", sizes, "9d")
    for stage in stages:
        print_row(stage, [cost.stages.get(stage, 0.0) for cost in costs])
    print_row("  of these, the report", [cost.page for cost in costs])
    print_row("total", totals)
    print_row("total per push", [total / size for total, size in zip(totals, sizes, strict=True)])
    print_row("wall time, s", [cost.clock for cost in costs])
    print_row("MiB before the diagnosis", [cost.before for cost in costs], "9.1f")
    print_row("MiB at the peak", [cost.peak for cost in costs], "9.1f")
    if len(sizes) > 1:
        print(f"CPU time grows as the number of pushes to the power of {growth_exponent(sizes, totals):.2f}")
    for size, cost in zip(sizes, costs, strict=True):
        print(f"{size} pushes: {cost.answer}")


def print_row(name: str, values: Sequence[float], form: str = "9.2f") -> None:
    """Print a row of the table."""
    print(f"{name:32}" + "".join(format(value, form) for value in values))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--pushes", type=int, nargs="+", default=[2, 4, 8, 16])
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.one is None:
        print_table(args.pushes, [measure_in_subprocess(pushes) for pushes in args.pushes])
    else:
        print(json.dumps(measure(args.one)._asdict()))


if __name__ == "__main__":
    main()
