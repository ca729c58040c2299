"""Tables of the benchmark of mechanisms."""

from __future__ import annotations

from typing import Any

from trundle.experiments.blind.tables import explained_misfits


def row(hidden: str, named: str, explained: float) -> dict[str, Any]:
    missing = [{"effect": named, "probability": 0.9, "where": {"joint": "elbow"}}]
    answer = {"verdict": "explained", "missing": missing, "tied": [], "explained": {"elbow": explained}}
    return {"answer": answer, "truth": {"names": [hidden], "outside": False}}


def test_names_are_counted_by_the_explained_part_of_the_misfit() -> None:
    refused = {"answer": {"verdict": "refused"}, "truth": {"names": ["a"], "outside": False}}
    rows = [row("a", "a", 1.0), row("a", "a", 0.8), row("a", "b", 0.2), row("a", "b", 0.8), refused]
    lines = [line.strip("| ").split(" | ") for line in explained_misfits(rows).splitlines()]
    assert ["0.15 to 0.25", "0", "1"] in lines
    assert ["0.75 to 1", "2", "1"] in lines
    assert ["0.5 to 0.75", "0", "0"] in lines
