"""Run the first blind benchmark: draw cases, seal the truth, diagnose the recordings."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import trundle
from trundle.experiments import versions
from trundle.experiments.backends import Backend
from trundle.experiments.blind.case import PlannedCase, draw_case, plan_cases, plan_limits
from trundle.experiments.blind.config import Settings
from trundle.experiments.blind.follow_up import (
    extend_recording,
    push_kinds,
    requested_experiment,
    restore_object,
)
from trundle.experiments.blind.sealed import digest, folder_digest, open_sealed, seal
from trundle.experiments.results import Row, read_trials, write_trials
from trundle.experiments.runner import Runner, Unit

__all__ = ["BlindBenchmark", "run_benchmark"]

Show = Callable[[str], object]


@dataclass(frozen=True)
class BlindBenchmark:
    """Settings and folders of a benchmark.

    Attributes
    ----------
    name : str
        Prefix of its files.
    settings : Settings
    work : Path
        Folder of recordings and finished units.
    results : Path
        Folder of the results.
    backend : Backend
    quiet : bool
    """

    name: str
    settings: Settings
    work: Path
    results: Path
    backend: Backend
    quiet: bool = False

    @property
    def sealed(self) -> Path:
        """File of the sealed truth, in the folder of results."""
        return self.results / f"{self.name}.answers.json"

    def file_of(self, part: str) -> Path:
        """File of results: "" for the first diagnoses, "_without" and "_after" for the second ones."""
        return self.results / f"{self.name}{part}.jsonl"

    def recording(self, case: str) -> Path:
        """Folder of a case. Its name does not depend on the hidden effect."""
        return self.work / "recordings" / case

    def run(self, label: str, version: str, units: Sequence[Unit]) -> list[Any]:
        """Run units whose results depend on a version of the code."""
        return Runner(self.work / "units", version, self.backend, self.quiet).run(label, units)


def run_benchmark(
    proof: BlindBenchmark, *, limits: bool, leave_out: bool, after_design: bool = False, tell: Show
) -> dict[str, Row]:
    """Run the units without a result, and return the truth of each case.

    The sealed truth is opened after all first diagnoses are finished.
    """
    drawn = draw_all(proof, plan_limits(proof.settings) if limits else plan_cases(proof.settings))
    sha = seal(proof.sealed, proof.settings.plain(), {case: one["truth"] for case, one in drawn.items()})
    tell(f"{len(drawn)} cases drawn; answers sealed, SHA-256 {sha}")
    digests = {case: one["digest"] for case, one in drawn.items() if one["digest"] is not None}
    diagnose_all(proof, sha, "", [(case, digests[case], {}) for case in digests])
    known = open_sealed(proof.sealed, sha)
    if leave_out:
        alone = {case: known[case]["names"][0] for case in digests if len(known[case]["names"]) == 1}
        trials = [
            (case, digests[case], {"without": name})
            for case, name in alone.items()
            if name in proof.settings.effects
        ]
        diagnose_all(proof, sha, "_without", trials)
    if after_design:
        diagnose_follow_ups(proof, sha, digests, known, tell)
    return known


def draw_all(proof: BlindBenchmark, planned: Sequence[PlannedCase]) -> dict[str, Row]:
    """Draw the cases without a result; return the truth and the digest of each."""
    units = [
        Unit(
            one.case,
            draw_one,
            {"planned": asdict(one), "settings": proof.settings.plain()},
            {"folder": proof.recording(one.case)},
            proof.recording(one.case),
        )
        for one in planned
    ]
    found = proof.run("drawing cases", versions.of_module("blind/case"), units)
    return {one.case: drawn for one, drawn in zip(planned, found, strict=True)}


def draw_one(planned: Row, settings: Row, folder: Path) -> Row:
    """Draw a case and write its recording; the digest is None if no draw was material."""
    drawn = draw_case(
        PlannedCase(**{**planned, "names": tuple(planned["names"])}), Settings.from_plain(settings)
    )
    if drawn.recording is None:
        return {"truth": drawn.answer, "digest": None}
    drawn.recording.write(folder, table="parquet")
    return {"truth": drawn.answer, "digest": folder_digest(folder)}


def diagnose_all(proof: BlindBenchmark, sha: str, part: str, trials: Sequence[tuple[str, str, Row]]) -> None:
    """Diagnose recordings, given as (case, digest, further names of the trial), and write the results."""
    units = [
        Unit(case, diagnose_one, {"digest": digest, **more}, {"recording": proof.recording(case)})
        for case, digest, more in trials
    ]
    found = proof.run("diagnosing", versions.of_diagnosis(), units)
    names = [{"case": case, **more} for case, _, more in trials]
    write_results(proof, sha, part, names, found)


def diagnose_follow_ups(
    proof: BlindBenchmark, sha: str, digests: dict[str, str], known: dict[str, Row], tell: Show
) -> None:
    """Simulate each requested push, diagnose the longer recordings, and write the results.

    The request comes from the answer alone. Only the simulation uses the truth.
    """
    asked = {one["case"]: requested_experiment(one) for one in read_trials(proof.file_of(""))[1]}
    asked = {case: experiment for case, experiment in asked.items() if experiment is not None}
    tell(f"{len(asked)} answers request a push")
    names = [{"case": case, "push": kind} for case in asked for kind in push_kinds(proof.settings)]
    units = [
        Unit(
            f"{name['case']}, {name['push']}",
            push_and_diagnose,
            {
                "settings": proof.settings.plain(),
                "kind": name["push"],
                "truth": known[name["case"]],
                "experiment": asked[name["case"]],
                "digest": digests[name["case"]],
            },
            {"recording": proof.recording(name["case"]), "longer": proof.work / "longer"},
        )
        for name in names
    ]
    version = f"{versions.of_module('blind/conduct')}-{versions.of_diagnosis()}"
    write_results(proof, sha, "_after", names, proof.run("pushing and diagnosing", version, units))


def write_results(
    proof: BlindBenchmark, sha: str, part: str, names: Sequence[Row], found: Sequence[Row]
) -> None:
    """Write one file of results, or raise if the sealed truth has changed since it was sealed."""
    if digest(proof.sealed) != sha:
        raise trundle.TrundleError(
            f"{proof.sealed}: the sealed file changed during the diagnoses: rerun with --fresh"
        )
    trials = [(name, one["answer"], one["cost"]) for name, one in zip(names, found, strict=True)]
    write_trials(proof.file_of(part), {**proof.settings.plain(), "sha256": sha}, trials)


def push_and_diagnose(
    settings: Row, kind: str, truth: Row, experiment: Row, digest: str, recording: Path, longer: Path
) -> Row:
    """Simulate one more push of a case's object, and diagnose the longer recording."""
    asked = Settings.from_plain(settings)
    made, effort = extend_recording(trundle.read(recording), *restore_object(truth, asked), kind, experiment)
    folder = longer / f"{recording.name}_{push_kinds(asked).index(kind)}"
    made.write(folder, table="parquet")
    found = diagnose_one(digest, folder)
    return {"answer": {**found["answer"], "effort": effort}, "cost": found["cost"]}


def diagnose_one(digest: str, recording: Path, without: str | None = None) -> Row:
    """Diagnose a folder through the public interface; return a summary of the answer and the duration, s."""
    began = time.perf_counter()
    try:
        answer = summarize_answer(
            trundle.diagnose(recording, without=[] if without is None else [without]).answer
        )
    except trundle.TrundleError as error:
        nothing: Row = {key: [] for key in ("missing", "tied", "alternatives", "experiments")}
        # The benchmark's folder must not appear in the answer.
        answer = {"verdict": "refused", "reason": str(error).replace(f"{recording.parent}/", ""), **nothing}
    return {"answer": answer, "cost": time.perf_counter() - began}


def summarize_answer(answer: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parts of `diagnosis.json` that scoring uses."""
    names = ("effect", "probability", "parameters", "where", "explains")
    held_out = answer["fit"]["held_out"] or {}
    windows = answer["mismatch"]["windows"]
    return {
        "verdict": answer["verdict"],
        "missing": [{name: one.get(name) for name in names} for one in answer["missing"]],
        "tied": answer["tied"],
        "alternatives": [{k: one[k] for k in ("effect", "probability")} for one in answer["alternatives"]],
        "experiments": [summarize_experiment(one) for one in answer["experiments"]],
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


def summarize_experiment(experiment: dict[str, Any]) -> dict[str, Any]:
    """Return the parts of a proposed experiment that simulating and scoring it use."""
    names = ("grasp", "direction", "start", "profile", "knots")
    pushes = [{name: push[name] for name in names} for push in experiment["pushes"]]
    return {**{name: experiment[name] for name in ("models", "separation", "sure")}, "pushes": pushes}
