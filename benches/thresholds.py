"""Count the numbers that a diagnosis hangs on: decision thresholds, and tolerances kept with their code."""

from __future__ import annotations

import re
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "adaptive/diagnose/src"
CONSTANT = re.compile(r"^\s*(?:pub\(crate\) )?const ([A-Z_]+): f64 = ([^;]+);", re.MULTILINE)


def main() -> None:
    """Print both counts, and the thresholds."""
    thresholds = CONSTANT.findall((SOURCE / "thresholds.rs").read_text())
    others = [path for path in sorted(SOURCE.rglob("*.rs")) if path.name != "thresholds.rs"]
    tolerances = sum(len(CONSTANT.findall(path.read_text())) for path in others)
    print(f"decision thresholds    {len(thresholds)}")
    for name, value in thresholds:
        print(f"  {name:20} {value}")
    print(f"numerical tolerances   {tolerances}")


if __name__ == "__main__":
    main()
