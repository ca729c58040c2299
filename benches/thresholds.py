"""Count the thresholds of verdicts and names, and the other constants of a diagnosis."""

from __future__ import annotations

import re
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "adaptive/diagnose/src"
NUMBER = r"(?:f64|usize|u32|u64|\[f64; \d+\])"
CONSTANT = re.compile(rf"^\s*(?:pub(?:\([a-z]+\))? )?const ([A-Z_]+): {NUMBER} = ([^;]+);", re.MULTILINE)


def main() -> None:
    """Print both counts and the thresholds."""
    thresholds = CONSTANT.findall((SOURCE / "thresholds.rs").read_text())
    others = [path for path in sorted(SOURCE.rglob("*.rs")) if path.name != "thresholds.rs"]
    constants = sum(len(CONSTANT.findall(path.read_text())) for path in others)
    print(f"verdicts and names             {len(thresholds)}")
    for name, value in thresholds:
        print(f"  {name:28} {value}")
    print(f"other constants                {constants}")


if __name__ == "__main__":
    main()
