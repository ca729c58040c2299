"""Files of a benchmark's results: answers, costs and the sealed truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trundle.experiments.blind.sealed import digest, open_sealed
from trundle.experiments.results import Row, read_headed, read_lines, write_lines
from trundle.recording import TrundleError

__all__ = ["ResultFiles", "Results"]


@dataclass(frozen=True)
class Results:
    """Results of a range, or of one of its shares.

    Attributes
    ----------
    head : dict
        `settings`, `code` (versions) and `sha256` of the sealed truth.
    rows : list of dict
        For each diagnosis `case`, `answer`, `truth` and `cost`, and `without` or `push` if there is one.
    truths : list of dict
        The truths of all cases, also of dropped ones.
    """

    head: Row
    rows: list[Row]
    truths: list[Row]


@dataclass(frozen=True)
class ResultFiles:
    """The files of a range or a share. `part` is "" for the first diagnoses, "_without" or "_after"."""

    folder: Path
    name: str

    @property
    def sealed(self) -> Path:
        """File of the sealed truth."""
        return self.folder / f"{self.name}.answers.json"

    def answers(self, part: str = "") -> Path:
        """Return the file of the answers."""
        return self.folder / f"{self.name}{part}.jsonl"

    def costs(self, part: str = "") -> Path:
        """Return the file of the costs of the diagnoses."""
        return self.folder / f"{self.name}{part}.cost.jsonl"

    def remove(self, *parts: str) -> None:
        """Remove answers and costs."""
        for part in parts:
            self.answers(part).unlink(missing_ok=True)
            self.costs(part).unlink(missing_ok=True)

    def depend_on(self, settings: Row, code: Row) -> bool:
        """Return whether there are answers of these settings and this code."""
        if not self.answers().exists():
            return False
        head = read_lines(self.answers())[0]
        return bool({"settings": settings, "code": code}.items() <= head.items())

    def write(self, part: str, head: Row, names: Sequence[Row], found: Sequence[Row]) -> list[Row]:
        """Write the answers, and their costs to another file; return the answers.

        Raises
        ------
        TrundleError
            If the sealed truth has changed since it was sealed.
        """
        if digest(self.sealed) != head["sha256"]:
            raise TrundleError(
                f"{self.sealed}: the sealed file changed during the diagnoses: rerun with --fresh"
            )
        answers = [{key: value for key, value in one.items() if key != "cost"} for one in found]
        rows = [{**name, "answer": answer} for name, answer in zip(names, answers, strict=True)]
        write_lines(self.costs(part), ({**n, **one["cost"]} for n, one in zip(names, found, strict=True)))
        write_lines(self.answers(part), [head, *rows])
        return rows

    def read(self, part: str = "") -> Results:
        """Read results, with the sealed truth of each case."""
        path = self.answers(part)
        settings, found = read_headed(path, ())
        head: Row = read_lines(path)[0]
        if "sha256" in settings:
            head = {"settings": settings, "sha256": settings.pop("sha256")}
            found = [from_first_form(line) for line in found]
        else:
            costs = read_lines(self.costs(part))
            found = [{**line, "cost": cost} for line, cost in zip(found, costs, strict=True)]
        truths = {
            case: with_ties(truth if "digest" in truth else from_first_truth(truth), settings)
            for case, truth in open_sealed(self.sealed, head["sha256"]).items()
        }
        return Results(head, [{**row, "truth": truths[row["case"]]} for row in found], list(truths.values()))


def with_ties(truth: Row, settings: Row) -> Row:
    """Return a truth with the largest number of tied sets in a correct answer.

    The benchmark of furniture has no limit.
    """
    return {**truth, "max_tie": None} if "episodes" in settings else truth


def from_first_form(line: Row) -> Row:
    """Return a row of results of the first blind benchmarks in the present form."""
    return {**line["trial"], "answer": line["found"], "cost": {"seconds": line["seconds"]}}


def from_first_truth(truth: Row) -> Row:
    """Return a truth of the first blind benchmarks in the present form."""
    redraws: Any = truth["redraws"] if "oracle" not in truth else truth["oracle"]["redraws"]
    attempts: list[Row] = [{"reason": "unknown"}] * redraws
    if "oracle" not in truth:
        return {**truth, "outside": False, "attempts": attempts, "digest": None}
    return {**truth, "outside": truth["foreign"], "attempts": [*attempts, {"reason": None}], "digest": ""}
