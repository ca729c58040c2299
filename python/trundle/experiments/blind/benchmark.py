"""Run a blind benchmark: draw cases, seal the truth, diagnose the recordings, write the results."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import trundle
from trundle.experiments import versions
from trundle.experiments.blind.diagnose import diagnose_case
from trundle.experiments.blind.follow_up import (
    extend_recording,
    push_kinds,
    requested_experiment,
    restore_object,
)
from trundle.experiments.blind.furniture import generator as furniture
from trundle.experiments.blind.mechanism import generator as mechanism
from trundle.experiments.blind.plan import plan_cases, plan_limits
from trundle.experiments.blind.result_files import ResultFiles
from trundle.experiments.blind.sealed import open_sealed, seal
from trundle.experiments.blind.settings import Settings
from trundle.experiments.blind.wide import generator as wide
from trundle.experiments.execution import Execution
from trundle.experiments.results import Row
from trundle.experiments.runner import Unit

__all__ = ["Benchmark", "code_versions", "run_benchmark"]

GENERATORS = {"furniture": furniture.draw, "wide": wide.draw, "mechanism": mechanism.draw}


@dataclass(frozen=True)
class Benchmark:
    """Settings and folders of a benchmark, or of one of its shares.

    Attributes
    ----------
    settings : Settings
    files : ResultFiles
    execution : Execution
        `recordings/` and finished units are in its folder `work`.
    limits : bool
        Measure detection limits instead of the main benchmark.
    """

    settings: Settings
    files: ResultFiles
    execution: Execution
    limits: bool = False

    def recording(self, case: str) -> Path:
        """Folder of a case. Its name does not depend on the hidden effects."""
        return self.execution.work / "recordings" / case

    def run(self, label: str, version: str, units: Sequence[Unit]) -> list[Any]:
        """Run units whose results depend on a version of the code."""
        return self.execution.run("units", label, units, version)


def code_versions(settings: Settings) -> dict[str, str]:
    """Return the versions of the generator and of the diagnosis, including the native code."""
    generator = versions.of_module(f"blind/{settings.generator}/generator")
    kind: Literal["planar", "joints"] = "joints" if settings.generator == "mechanism" else "planar"
    return {"generator": generator, "diagnosis": versions.of_diagnosis(kind)}


def run_benchmark(benchmark: Benchmark, *, leave_out: bool = False, after_design: bool = False) -> None:
    """Run the units without a result, and write the results.

    The sealed truth is opened after all first diagnoses are finished.
    """
    settings, files = benchmark.settings, benchmark.files
    truths = draw_all(benchmark)
    sha = seal(files.sealed, settings.plain(), truths)
    digests = {case: one["digest"] for case, one in truths.items() if one["digest"] is not None}
    print_status(f"{len(digests)} of {len(truths)} cases drawn; answers sealed, SHA-256 {sha}")
    head = {"settings": settings.plain(), "code": code_versions(settings), "sha256": sha}
    first = diagnose_all(benchmark, head, "", [(case, digests[case], {}) for case in digests])
    known = open_sealed(files.sealed, sha)
    if leave_out:
        alone = [case for case in digests if len(known[case]["names"]) == 1 and not known[case]["outside"]]
        trials = [(case, digests[case], {"without": known[case]["names"][0]}) for case in alone]
        diagnose_all(benchmark, head, "_without", trials)
    if after_design:
        diagnose_follow_ups(benchmark, head, first, known)


def print_status(text: str) -> None:
    """Print a status line to standard error."""
    print(text, file=sys.stderr, flush=True)


def draw_all(benchmark: Benchmark) -> dict[str, Row]:
    """Draw the cases without a result, and return all truths by case."""
    settings = benchmark.settings
    units = []
    for one in plan_limits(settings) if benchmark.limits else plan_cases(settings):
        folder = benchmark.recording(one.case)
        arguments = {"planned": asdict(one), "options": settings.drawing()}
        draw = GENERATORS[settings.generator]
        units.append(Unit(one.case, draw, arguments, {"folder": folder}, folder))
    found = benchmark.run("drawing", code_versions(settings)["generator"], units)
    return {one["case"]: one for one in found}


def diagnose_all(
    benchmark: Benchmark, head: Row, part: str, trials: Sequence[tuple[str, str, Row]]
) -> list[Row]:
    """Diagnose recordings, given as (case, digest, further names of the trial); write and return the results.

    A diagnosis receives only the recording and its digest.
    """
    settings = benchmark.settings
    common = {"limit": settings.limit, "experiments": settings.generator == "furniture"}
    units = []
    for case, digest, more in trials:
        arguments = {"digest": digest, **common, "without": list(more.values())}
        units.append(Unit(case, diagnose_case, arguments, {"folder": benchmark.recording(case)}))
    found = benchmark.run("diagnosing", head["code"]["diagnosis"], units)
    names = [{"case": case, **more} for case, _, more in trials]
    return benchmark.files.write(part, head, names, found)


def diagnose_follow_ups(benchmark: Benchmark, head: Row, first: Sequence[Row], known: dict[str, Row]) -> None:
    """Simulate each requested push, diagnose the longer recordings, and write the results.

    The request comes from the answer alone. Only the simulation uses the truth.
    """
    settings = benchmark.settings
    asked = {row["case"]: requested_experiment(row["answer"]) for row in first}
    asked = {case: experiment for case, experiment in asked.items() if experiment is not None}
    print_status(f"{len(asked)} answers request a push")
    names = [{"case": case, "push": kind} for case in asked for kind in push_kinds(settings.alike)]
    units = []
    for name in names:
        case, kind = name["case"], name["push"]
        arguments = {
            "options": settings.drawing(),
            "limit": settings.limit,
            "kind": kind,
            "truth": known[case],
            "experiment": asked[case],
        }
        folders = {"recording": benchmark.recording(case), "longer": benchmark.execution.work / "longer"}
        units.append(Unit(f"{case}, {kind}", push_and_diagnose, arguments, folders))
    version = f"{versions.of_module('blind/follow_up')}-{head['code']['diagnosis']}"
    benchmark.files.write("_after", head, names, benchmark.run("pushing and diagnosing", version, units))


def push_and_diagnose(
    options: Row, limit: float, kind: str, truth: Row, experiment: Row, recording: Path, longer: Path
) -> Row:
    """Simulate one more push of a case's object, and diagnose the longer recording."""
    scene, hidden = restore_object(truth, options)
    made, effort = extend_recording(trundle.read(recording), scene, hidden, kind, experiment)
    folder = longer / f"{recording.name}_{push_kinds(options['alike']).index(kind)}"
    made.write(folder, table="parquet")
    return {**diagnose_case(truth["digest"], limit, folder, experiments=True), "effort": effort}
