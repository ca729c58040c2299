"""Run `trundle prove` with the file of a wide benchmark."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trundle.atomic import write_text
from trundle.experiments.backends import Backend
from trundle.experiments.blind.run import print_status
from trundle.experiments.blind.sealed import open_sealed
from trundle.experiments.results import read_lines, write_lines
from trundle.experiments.wide import tables
from trundle.experiments.wide.benchmark import WideBenchmark, code_versions, run_benchmark
from trundle.experiments.wide.config import Settings, read
from trundle.experiments.wide.score import GROUPS, Row, case_group
from trundle.recording import TrundleError

__all__ = ["prove_wide"]


def prove_wide(
    config: Path,
    which: str,
    work: Path,
    out: Path,
    *,
    backend: Backend,
    shares: int | None = None,
    fresh: bool = False,
    redraw: bool = False,
    quiet: bool = False,
) -> str:
    """Run the unfinished part of a wide benchmark, and write its page.

    Parameters
    ----------
    config : Path
        Settings file.
    which : str
        A range of the file.
    work : Path
        Folder of recordings and finished units; an interrupted run continues from it.
    out : Path
        Folder of the page and of `wide/` (results, sealed truth, costs).
    backend : Backend
        Where units run.
    shares : int, optional
        Largest number of shares to run: the first of those without results of this code version in `out`. By
        default all of them.
    fresh, redraw : bool
        Discard earlier results; or only write the page.
    quiet : bool
        Show no progress.

    Returns
    -------
    str
        The page, of the shares that have results.
    """
    settings = read(config, which)
    name = config.stem if which == "report" else f"{config.stem}_{which}"
    places = [RangeFiles(one, out / "wide", name) for one in settings.parts()]
    if not redraw:
        if fresh:
            shutil.rmtree(work / "wide", ignore_errors=True)
        for place in [place for place in places if fresh or not place.done()][:shares]:
            place.fill(WideBenchmark(place.settings, work / "wide", backend, quiet))
    there = [place for place in places if place.results.exists()]
    if not there:
        raise TrundleError(f"{places[0].results}: no results to draw: run without --redraw")
    text = render_page(settings, there)
    write_text(out / f"{name}.md", text)
    return text


@dataclass(frozen=True)
class RangeFiles:
    """A range, or a share of one, and the files of its results."""

    settings: Settings
    folder: Path
    range_name: str

    @property
    def name(self) -> str:
        """Prefix of the files' names."""
        share = self.settings.share
        return self.range_name if share is None else f"{self.range_name}_{share:02}"

    @property
    def results(self) -> Path:
        """File of the answers."""
        return self.folder / f"{self.name}.jsonl"

    @property
    def sealed(self) -> Path:
        """File of the sealed truth."""
        return self.folder / f"{self.name}.answers.json"

    @property
    def costs(self) -> Path:
        """File of the costs of the diagnoses."""
        return self.folder / f"{self.name}.cost.jsonl"

    def head(self) -> dict[str, Any]:
        """Return what the results depend on."""
        return {"settings": self.settings.plain(), "code": code_versions()}

    def done(self) -> bool:
        """Return whether a share has results of these settings and this code; False for a whole range."""
        if self.settings.share is None or not self.results.exists():
            return False
        head = read_lines(self.results)[0]
        return bool(self.head().items() <= head.items())

    def fill(self, benchmark: WideBenchmark) -> None:
        """Draw, seal and diagnose, and write the results."""
        sha, rows = run_benchmark(benchmark, self.sealed, print_status)
        answers = [{key: v for key, v in row["answer"].items() if key != "cost"} for row in rows]
        found = [{"case": row["case"], "answer": answer} for row, answer in zip(rows, answers, strict=True)]
        write_lines(self.costs, ({"case": row["case"], **row["answer"]["cost"]} for row in rows))
        write_lines(self.results, [{**self.head(), "sha256": sha}, *found])

    def rows(self) -> tuple[dict[str, Any], list[Row], list[Row]]:
        """Return the head, a row for every diagnosed case, and all truths."""
        head, *found = read_lines(self.results)
        truths: dict[str, Any] = open_sealed(self.sealed, head["sha256"])
        spent = {one["case"]: one for one in read_lines(self.costs)}
        rows = [{**one, "truth": truths[one["case"]], "cost": spent[one["case"]]} for one in found]
        return head, rows, list(truths.values())


def render_page(settings: Settings, places: Sequence[RangeFiles]) -> str:
    """Return the page of the stored results."""
    parts = [place.rows() for place in places]
    rows = [row for _, found, _ in parts for row in found]
    truths = [truth for *_, found in parts for truth in found]
    sections = [
        ("Targets", tables.accuracy(rows)),
        ("By instrument", tables.instruments(rows)),
        ("Single effects", tables.effects(rows)),
        ("Wrong answers: clean recordings, and several effects", tables.wrong_answers(rows)),
        ("Intervals of 90 %", tables.intervals(rows)),
        ("Probabilities", tables.probabilities(rows)),
        ("Cost of a diagnosis", tables.costs(rows)),
        ("Rejected draws", tables.rejections(truths)),
    ]
    body = [f"## {title}\n\n{text}" for title, text in sections]
    return "\n\n".join([intro(settings, [head for head, *_ in parts], rows, truths), *body]) + "\n"


def intro(
    settings: Settings, heads: Sequence[dict[str, Any]], rows: Sequence[Row], truths: Sequence[Row]
) -> str:
    """Return the introduction: the benchmark, the number of recordings, and the version of the code."""
    counts = ", ".join(f"{sum(case_group(row['truth']) == name for row in rows)} {name}" for name in GROUPS)
    given_up = sum(truth["digest"] is None for truth in truths)
    versions = sorted({head["code"]["diagnosis"].split("-")[0] for head in heads})
    return INTRO.format(
        name=settings.range,
        done=f", {len(heads)} of {settings.shares} shares" if settings.shares > 1 else "",
        total=len(rows),
        counts=counts,
        given_up=given_up,
        versions=", ".join(f"`{one}`" for one in versions),
        sha=", ".join(f"`{head['sha256']}`" for head in heads),
    )


INTRO = """# The wide blind benchmark

Recordings of pushed objects with random instruments and conventions: a tracker (10 to 250 Hz, up to half of
the poses lost, time jitter, 0.1 to 3 mm), a sensor (50 to 1000 Hz, with or without an anti-alias filter),
axes, reference point and sign of the reading, raw or tared readings, stated or unknown noise. The object is
pushed by a rigid grasp, a compliant grasp or a free finger, in 3 to 20 pushes of 2 to 20 s, and has a
random outline. MuJoCo simulates half of the recordings. A solver of ordinary differential equations with
its own contacts, dry friction and casters simulates the other half. The simulations use no law of trundle.

A case is material if, with its own instrument, the true model reduces the held-out misfit of the refitted
nominal model at least threefold, and each of several effects at least twofold. Correct answers are the
exact set of effects or a certified tie of at most three sets that contains it; "consistent" for clean
recordings; "unexplained" out of the catalogue. Brackets: Wilson's intervals of 95 %.

Range `{name}`{done}: {total} recordings ({counts}); {given_up} cases were dropped. Version of the
diagnosing sources: {versions}. A diagnosis receives only the recording's folder. The truth is sealed in a
file whose SHA-256 was printed before the first diagnosis: {sha}."""
