"""`trundle prove` with a wide benchmark's file: from the file to the page."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from trundle.experiments.runner import collect, write_lines
from trundle.experiments.wide import tables
from trundle.experiments.wide.conduct import Benchmark, conduct
from trundle.experiments.wide.config import read
from trundle.experiments.wide.score import GROUPS, Row, group
from trundle.proof.sealed import open_sealed
from trundle.recording import TrundleError
from trundle.whole import write_text

__all__ = ["prove_wide"]


def prove_wide(
    config: Path,
    which: str,
    work: Path,
    out: Path,
    *,
    jobs: int = 1,
    fresh: bool = False,
    redraw: bool = False,
    quiet: bool = False,
) -> str:
    """Do what has not been done of a wide benchmark, and write its page.

    Parameters
    ----------
    config : Path
        The benchmark's file.
    which : str
        A range of the file.
    work : Path
        Folder of recordings and of finished units; an interrupted run continues from it.
    out : Path
        Folder of the page and of `wide/` (results, sealed answers, costs).
    jobs : int
        Processes.
    fresh, redraw : bool
        Begin anew; or only write the page.
    quiet : bool
        Show no progress.

    Returns
    -------
    str
        The page.
    """
    settings = read(config, which)
    name = config.stem if which == "report" else f"{config.stem}_{which}"
    kept = out / "wide"
    results, sealed = kept / f"{name}.jsonl", kept / f"{name}.answers.json"
    if not redraw:
        if fresh:
            shutil.rmtree(work / "wide", ignore_errors=True)
        benchmark = Benchmark(settings, work / "wide", jobs, quiet)
        sha, rows = conduct(benchmark, sealed, tell)
        head = {"settings": settings.plain(), "sha256": sha}
        answers = [{key: v for key, v in row["answer"].items() if key != "cost"} for row in rows]
        found = zip(rows, answers, strict=True)
        write_lines(results, [head, *({"case": row["case"], "answer": answer} for row, answer in found)])
        spent = ({"case": row["case"], **row["answer"]["cost"]} for row in rows)
        write_lines(kept / f"{name}.cost.jsonl", spent)
    if not results.exists():
        raise TrundleError(f"{results}: there are no results to draw; leave out --redraw")
    text = page(kept, name)
    write_text(out / f"{name}.md", text)
    return text


def tell(text: str) -> None:
    """Report something at once, beside the answer."""
    print(text, file=sys.stderr, flush=True)


def page(kept: Path, name: str) -> str:
    """Return the page from the results that are kept."""
    head, *found = collect(kept / f"{name}.jsonl")
    truths: dict[str, Any] = open_sealed(kept / f"{name}.answers.json", head["sha256"])
    spent = {one["case"]: one for one in collect(kept / f"{name}.cost.jsonl")}
    rows = [{**one, "truth": truths[one["case"]], "cost": spent[one["case"]]} for one in found]
    sections = [
        ("What was to be reached", tables.accuracy(rows)),
        ("By instrument", tables.instruments(rows)),
        ("Hidden alone", tables.effects(rows)),
        ("Answers that are not right: clean recordings, and several effects", tables.wrong_answers(rows)),
        ("Intervals of 90 %", tables.intervals(rows)),
        ("Probabilities", tables.probabilities(rows)),
        ("What a diagnosis costs", tables.costs(rows)),
        ("Draws that did not count", tables.rejections(list(truths.values()))),
    ]
    body = [f"## {title}\n\n{text}" for title, text in sections]
    return "\n\n".join([intro(head, rows, list(truths.values())), *body]) + "\n"


def intro(head: dict[str, Any], rows: Sequence[Row], truths: Sequence[Row]) -> str:
    """Return what the benchmark is, and how many recordings it has."""
    counts = ", ".join(f"{sum(group(row['truth']) == name for row in rows)} {name}" for name in GROUPS)
    given_up = sum(truth["digest"] is None for truth in truths)
    return INTRO.format(
        name=head["settings"]["range"], total=len(rows), counts=counts, given_up=given_up, sha=head["sha256"]
    )


INTRO = """# The wide blind benchmark

Recordings of pushed objects in which everything varies that varies between laboratories: the tracker (10
to 250 Hz, up to half of the poses lost, time jitter, 0.1 to 3 mm), the sensor (50 to 1000 Hz, with or
without an anti-alias filter), the axes, reference point and sign of the reading, raw or tared, noise
stated or not; a rigid grasp, a compliant grasp, or a finger that pushes freely; 3 to 20 pushes of 2 to 20
s; outlines of all kinds. Half of the recordings come from MuJoCo, half from a solver of ordinary
differential equations with its own contact, dry friction and casters. No law of trundle makes a
recording.

A case counts if, with its own instrument, the true model improves the held-out misfit of the refitted
nominal model at least threefold, and each of several effects at least twofold. Right is the exact set of
effects, or a certified tie of at most three sets that contains it; "consistent" on clean recordings;
"unexplained" out of the catalogue. In brackets: Wilson's intervals of 95 %.

Range `{name}`: {total} recordings ({counts}); {given_up} cases were given up. A diagnosis sees the folder
of the recording alone. The answers are sealed in one file whose SHA-256 was printed before the first
diagnosis: `{sha}`."""
