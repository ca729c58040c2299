"""The decision thresholds of a diagnosis are few, and a script counts them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_script_counts_every_threshold() -> None:
    source = (ROOT / "adaptive/diagnose/src/thresholds.rs").read_text()
    script = [sys.executable, str(ROOT / "benches/thresholds.py")]
    printed = subprocess.run(script, check=True, capture_output=True, text=True).stdout.splitlines()
    count = int(printed[0].split()[-1])
    assert printed[0].startswith("verdicts and names")
    assert count == sum("const " in line and "fn " not in line for line in source.splitlines())
    assert 0 < count <= 10
