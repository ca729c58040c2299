"""Time of `import trundle` in new processes, and the share of its dependencies.

    .venv/bin/python benches/import_time.py [--runs 10]

The minimum of several runs is the time without disturbance by other processes.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time

GOAL_S = 0.3
STATEMENTS = ("pass", "import numpy", "import gymnasium", "import trundle")
"""From the interpreter alone to trundle; each includes the previous one."""


def main() -> None:
    """Print the minimum time of each statement."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=10, help="number of processes for each line (default 10)")
    runs = parser.parse_args().runs
    for statement in STATEMENTS:
        print(f"{statement:18}{min(seconds(statement) for _ in range(runs)):6.3f} s")
    print(f"goal for `import trundle`: {GOAL_S} s")


def seconds(statement: str) -> float:
    """Return the duration of a process that executes a statement, s."""
    began = time.perf_counter()
    subprocess.run([sys.executable, "-c", statement], check=True)
    return time.perf_counter() - began


if __name__ == "__main__":
    main()
