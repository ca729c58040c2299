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
from trundle.proof.further import asked_for, kinds, lengthened, same_object
from trundle.proof.pool import in_parallel
from trundle.proof.sealed import digest, open_sealed, seal
from trundle.whole import write_text

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

    def file_of(self, part: str) -> Path:
        """File of results: "" of the first diagnoses, "_without" and "_after" of the second."""
        return self.results / f"{self.name}{part}.jsonl"

    def recording(self, case: str) -> Path:
        """Folder of a case: its path tells nothing."""
        return self.work / "recordings" / case

    def drawn(self, case: str) -> Path:
        """File of a case's answer until all are sealed."""
        return self.work / "drawn" / f"{case}.json"


def conduct(
    proof: Proof, *, limits: bool, leave_out: bool, after_design: bool = False, tell: Show
) -> dict[str, dict[str, Any]]:
    """Do what has not been done yet; return the answers, opened after the last first diagnosis."""
    planned = plan_limits(proof.settings) if limits else plan(proof.settings)
    sha = sealed(proof, planned)
    tell(f"{len(planned)} cases drawn; answers sealed, SHA-256 {sha}")
    diagnosed(proof, planned, sha, without=None)
    if leave_out:
        known = open_sealed(proof.sealed, sha)
        diagnosed(proof, planned, sha, without={case: found["names"] for case, found in known.items()})
    if after_design:
        pushed_again(proof, planned, sha, tell)
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
    """Diagnose the recordings that have not been."""
    trials = trials_of(proof, planned, without)
    calls = [(proof.recording(trial["case"]), trial.get("without")) for trial in trials]
    part = "" if without is None else "_without"
    answered(proof, sha, part, trials, calls, diagnose_one)


def pushed_again(proof: Proof, planned: Sequence[Planned], sha: str, tell: Show) -> None:
    """Push once more where an answer asks for it, and diagnose again.

    What is asked for comes from the answer alone; only what makes the push knows what is hidden.
    """
    known, first = open_sealed(proof.sealed, sha), results_of(proof, "", sha)
    asked = {}
    for trial in trials_of(proof, planned, None):
        answer = first.of(trial)
        experiment = None if answer is None else asked_for(answer)
        if experiment is not None:
            asked[trial["case"]] = experiment
    tell(f"{len(asked)} answers ask for a push")
    trials = [{"case": case, "push": kind} for case in asked for kind in kinds(proof.settings)]
    calls = [
        (replace(proof, jobs=1), trial["case"], trial["push"], known[trial["case"]], asked[trial["case"]])
        for trial in trials
    ]
    answered(proof, sha, "_after", trials, calls, push_and_diagnose)


def answered(
    proof: Proof,
    sha: str,
    part: str,
    trials: Sequence[dict[str, Any]],
    calls: Sequence[tuple[Any, ...]],
    work: Callable[..., tuple[dict[str, Any], float]],
) -> None:
    """Do the trials of a part that have not been done, each by its call, and keep each answer at once."""
    results = results_of(proof, part, sha)
    missing = [k for k, trial in enumerate(trials) if results.of(trial) is None]
    with Progress("diagnosing", len(missing), quiet=proof.quiet) as progress:
        for number, (found, seconds) in in_parallel(work, [calls[k] for k in missing], proof.jobs):
            results.add(trials[missing[number]], found, seconds)
            progress.step()
    if digest(proof.sealed) != sha:
        raise trundle.TrundleError(f"{proof.sealed}: changed while the diagnoses were made")


def results_of(proof: Proof, part: str, sha: str) -> Results:
    """Return the results of a part of the proof that are there: of these settings and these answers."""
    return Results(proof.file_of(part), {**proof.settings.plain(), "sha256": sha})


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


def push_and_diagnose(
    proof: Proof, case: str, kind: str, truth: dict[str, Any], experiment: dict[str, Any]
) -> tuple[dict[str, Any], float]:
    """Push the hidden object of a case once more, and diagnose its longer recording."""
    recording = trundle.read(proof.recording(case))
    longer, effort = lengthened(recording, *same_object(truth, proof.settings), kind, experiment)
    folder = proof.work / "longer" / f"{case}_{kinds(proof.settings).index(kind)}"
    longer.write(folder, table="parquet")
    answer, seconds = diagnose_one(folder, None)
    return {**answer, "effort": effort}, seconds


def diagnose_one(recording: Path, without: str | None) -> tuple[dict[str, Any], float]:
    """Diagnose a folder through the public interface; return what is kept of the answer, and seconds."""
    began = time.perf_counter()
    more: dict[str, Any] = {} if without is None else {"without": [without]}
    try:
        answer = trundle.diagnose(recording, **more).answer
    except trundle.TrundleError as error:
        nothing: dict[str, Any] = {key: [] for key in ("missing", "tied", "alternatives", "experiments")}
        # Where the proof's folder lies is nobody's concern, and another run's lies elsewhere.
        reason = str(error).replace(f"{recording.parent}/", "")
        refused = {"verdict": "refused", "reason": reason, **nothing}
        return refused, time.perf_counter() - began
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
        "experiments": [kept_experiment(one) for one in answer["experiments"]],
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


def kept_experiment(experiment: dict[str, Any]) -> dict[str, Any]:
    """Return what carrying it out needs of an experiment, and what it promises."""
    names = ("grasp", "direction", "start", "profile", "knots")
    pushes = [{name: push[name] for name in names} for push in experiment["pushes"]]
    return {**{name: experiment[name] for name in ("models", "separation", "sure")}, "pushes": pushes}
