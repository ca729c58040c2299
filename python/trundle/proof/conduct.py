"""A proof from its settings to its results: draw, seal, diagnose; each step goes on where it was."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import trundle
from trundle.cli.progress import Progress
from trundle.paper.results import Results, rounded
from trundle.proof.case import Planned, draw, plan, plan_limits
from trundle.proof.config import Settings
from trundle.proof.pool import in_parallel
from trundle.proof.sealed import digest, open_sealed, seal, write_text

__all__ = ["Proof", "conduct"]

Show = Callable[[str], object]


@dataclass(frozen=True)
class Proof:
    """Where a proof is done.

    Attributes
    ----------
    name : str
        Of its files.
    settings : Settings
    work : Path
        Folder of recordings and, beside them, answers.
    results : Path
        Folder of the results that are kept.
    jobs : int
    quiet : bool
    """

    name: str
    settings: Settings
    work: Path
    results: Path
    jobs: int = 1
    quiet: bool = False

    @property
    def sealed(self) -> Path:
        """The sealed answers; kept with the results."""
        return self.results / f"{self.name}.answers.json"

    def recording(self, case: str) -> Path:
        """Folder of a case: its path tells nothing."""
        return self.work / "recordings" / case

    def drawn(self, case: str) -> Path:
        """File of a case's answer until all are sealed."""
        return self.work / "drawn" / f"{case}.json"


def conduct(proof: Proof, *, limits: bool, leave_out: bool, tell: Show) -> dict[str, dict[str, Any]]:
    """Do what has not been done yet; return the answers, opened after the last diagnosis."""
    planned = plan_limits(proof.settings) if limits else plan(proof.settings)
    sha = sealed(proof, planned)
    tell(f"{len(planned)} cases drawn; answers sealed, SHA-256 {sha}")
    diagnosed(proof, planned, sha, without=None)
    if leave_out:
        known = open_sealed(proof.sealed, sha)
        diagnosed(proof, planned, sha, without={case: found["names"] for case, found in known.items()})
    return open_sealed(proof.sealed, sha)


def sealed(proof: Proof, planned: Sequence[Planned]) -> str:
    """Draw the cases that are missing, seal all answers, and return the SHA-256."""
    settings = proof.settings.plain()
    marker = proof.work / "settings.json"
    if marker.exists() and json.loads(marker.read_text(encoding="utf-8")) != settings:
        raise trundle.TrundleError(
            f"{proof.work}: holds cases of other settings; give another --work or remove it"
        )
    write_text(marker, json.dumps(settings))
    missing = [one for one in planned if not proof.drawn(one.case).exists()]
    calls = [(replace(proof, jobs=1), one) for one in missing]
    with Progress("drawing cases", len(missing), quiet=proof.quiet) as progress:
        for _ in in_parallel(draw_one, calls, proof.jobs):
            progress.step()
    answers = {one.case: json.loads(proof.drawn(one.case).read_text(encoding="utf-8")) for one in planned}
    return seal(proof.sealed, settings, answers)


def draw_one(proof: Proof, planned: Planned) -> None:
    """Draw a case; its answer is written last, so that one without it is drawn again."""
    drawn = draw(planned, proof.settings)
    if drawn.recording is not None:
        drawn.recording.write(proof.recording(planned.case), table="parquet")
    write_text(proof.drawn(planned.case), json.dumps(rounded(drawn.answer)))


def diagnosed(
    proof: Proof, planned: Sequence[Planned], sha: str, without: dict[str, list[str]] | None
) -> None:
    """Diagnose the recordings that have not been, and keep each answer at once."""
    results = Results(results_of(proof, without is not None), {**proof.settings.plain(), "sha256": sha})
    trials = trials_of(proof, planned, without)
    missing = [trial for trial in trials if results.of(trial) is None]
    calls = [(proof.recording(trial["case"]), trial.get("without")) for trial in missing]
    with Progress("diagnosing", len(missing), quiet=proof.quiet) as progress:
        for number, (found, seconds) in in_parallel(diagnose_one, calls, proof.jobs):
            results.add(missing[number], found, seconds)
            progress.step()
    if digest(proof.sealed) != sha:
        raise trundle.TrundleError(f"{proof.sealed}: changed while the diagnoses were made")


def results_of(proof: Proof, leave_out: bool) -> Path:
    """Return the file of the results."""
    return proof.results / f"{proof.name}{'_without' if leave_out else ''}.jsonl"


def trials_of(
    proof: Proof, planned: Sequence[Planned], without: dict[str, list[str]] | None
) -> list[dict[str, Any]]:
    """Return what names each diagnosis: a case, and what is left out of the candidates."""
    there = [one for one in planned if proof.recording(one.case).exists()]
    if without is None:
        return [{"case": one.case} for one in there]
    alone = {case: names[0] for case, names in without.items() if len(names) == 1}
    effects = proof.settings.effects
    return [{"case": one.case, "without": alone[one.case]} for one in there if alone.get(one.case) in effects]


def diagnose_one(recording: Path, without: str | None) -> tuple[dict[str, Any], float]:
    """Diagnose a folder through the public interface; return what is kept of the answer, and seconds."""
    began = time.perf_counter()
    more: dict[str, Any] = {} if without is None else {"without": [without]}
    try:
        answer = trundle.diagnose(recording, **more).answer
    except trundle.TrundleError as error:
        return {"verdict": "refused", "reason": str(error)}, time.perf_counter() - began
    return kept(answer), time.perf_counter() - began


def kept(answer: dict[str, Any]) -> dict[str, Any]:
    """Return what scoring needs of `diagnosis.json`."""
    names = ("effect", "probability", "parameters", "where", "explains")
    held_out = answer["fit"]["held_out"] or {}
    windows = answer["mismatch"]["windows"]
    return {
        "verdict": answer["verdict"],
        "missing": [{name: one.get(name) for name in names} for one in answer["missing"]],
        "tied": answer["tied"],
        "alternatives": [{k: one[k] for k in ("effect", "probability")} for one in answer["alternatives"]],
        "mismatch": {
            "body_point": answer["mismatch"]["body_point"],
            "world_region": answer["mismatch"]["world_region"],
            "strength": max((window["strength"] for window in windows), default=0.0),
        },
        "held_out": {
            when: {k: v for k, v in figures.items() if v is None or math.isfinite(v)}
            for when, figures in held_out.items()
        },
    }
