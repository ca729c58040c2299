"""Diagnose published recordings of joints: the table "Recordings of joints" of docs/real-recordings.md.

    python examples/real_joints.py DATA

DATA contains `xl330/`, `so101/`, `pendulum/`, `pneumatic-seal/` and `emps/`; docs/real-recordings.md
names the sources.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import trundle
from trundle import importers

IMPORT = Path(__file__).resolve().parents[1] / "configs" / "import"
SO101 = ("Rotation", "Pitch", "Elbow", "Wrist_Pitch", "Wrist_Roll", "Jaw")


@dataclass(frozen=True)
class Source:
    """One recording: its files, how they are imported, and what is known."""

    name: str
    files: str
    layout: str
    known: str
    settings: Mapping[str, Any] = field(default_factory=dict)


SOURCES = [
    Source("XL330", "xl330", "xl330", "friction grows with the load (published)"),
    *(
        Source(f"SO-101 {joint}", "so101", "so101", "stick-slip is plain", {"joint": joint})
        for joint in SO101
    ),
    Source("single pendulum", "pendulum/single.mat", "pendulum", "viscous friction (published)"),
    *(
        Source(
            f"seal, {kind}",
            "pneumatic-seal",
            "pneumatic-seal",
            "dry, grows with pressure (published); offset",
            {"format": 2, "files": [f"{kind}_{bar}bar" for bar in (1, 3, 5, 7)]},
        )
        for kind in ("O-ring", "X-ring257")
    ),
    Source("EMPS", "emps", "emps", "dry 20.4 N, offset -3.2 N (published)", {"format": 2}),
]


def row(data: Path, source: Source) -> str:
    """Import and diagnose one recording, and return its row of the table."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "recording"
        found = importers.read(data / source.files, source.layout, dict(source.settings) or None)
        trundle.JointRecording(found.metadata, found.episodes, files=found.files).write(path)
        begun = time.monotonic()
        answer = trundle.diagnose(path, check=False, progress=False).answer
        seconds = time.monotonic() - begun
    cells = [source.name, source.known, named(answer), figures(answer), f"{seconds:.0f}"]
    return f"| {' | '.join(cells)} |"


def named(answer: Mapping[str, Any]) -> str:
    """Return the verdict and the effects with their strengths."""
    effects = [f"{effect['statement']} ({effect['probability']:.2f})" for effect in answer["missing"]]
    ties = "; ".join(" = ".join(tie) for tie in answer["tied"])
    return f"{answer['verdict']}: {' '.join(effects)}" + (f" Tied: {ties}." if ties else "")


def figures(answer: Mapping[str, Any]) -> str:
    """Return the held-out errors before and after."""
    held_out = answer["fit"]["held_out"]
    if held_out is None:
        return "none held out"
    parts = []
    names = {"position_rmse": "open loop", "window_position_rmse": "1 s ahead", "effort_rmse": "effort"}
    for joint, before in held_out["before"]["joints"].items():
        after = held_out["after"]["joints"][joint]
        for key, text in names.items():
            if before[key] is not None and after[key] is not None:
                parts.append(f"{text} {before[key]:.3g} -> {after[key]:.3g}")
    return "; ".join(parts)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", metavar="DATA", type=Path, help="folder with the data sets")
    data = parser.parse_args().data
    print("| recording | known | answer | held out: before -> after | time, s |")
    print("| --- | --- | --- | --- | --- |")
    for source in SOURCES:
        print(row(data, source), flush=True)


if __name__ == "__main__":
    main()
