"""Run a wide benchmark: draw cases, seal the truth, diagnose the recordings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trundle.experiments import versions
from trundle.experiments.backends import Backend
from trundle.experiments.blind.sealed import open_sealed, seal
from trundle.experiments.runner import Runner, Unit
from trundle.experiments.wide.case import draw_case
from trundle.experiments.wide.config import Settings
from trundle.experiments.wide.diagnose import diagnose_case
from trundle.experiments.wide.plan import PlannedCase, plan_cases

__all__ = ["WideBenchmark", "code_versions", "run_benchmark"]


@dataclass(frozen=True)
class WideBenchmark:
    """Settings and folder of a benchmark.

    Attributes
    ----------
    settings : Settings
    work : Path
        Folder of recordings and finished units.
    backend : Backend
    quiet : bool
    """

    settings: Settings
    work: Path
    backend: Backend
    quiet: bool = False

    def recording(self, case: str) -> Path:
        """Folder of a case. Its name does not depend on the hidden effects."""
        return self.work / self.settings.parent / "recordings" / case

    def runner(self, version: str) -> Runner:
        """Return the runner of units that depend on a version of the code."""
        return Runner(self.work / "units", version, self.backend, self.quiet)


def run_benchmark(
    benchmark: WideBenchmark, sealed: Path, tell: Callable[[str], object]
) -> tuple[str, list[dict[str, Any]]]:
    """Run the units without a result; return the SHA-256 of the sealed truth, and a row for every case.

    The sealed truth is opened after all diagnoses are finished. A row holds the case, its answer with the
    cost, and the truth.
    """
    truths = draw_all(benchmark, plan_cases(benchmark.settings))
    sha = seal(sealed, benchmark.settings.plain(), {one["case"]: without_values(one) for one in truths})
    there = [one["case"] for one in truths if one["digest"] is not None]
    tell(f"{len(there)} of {len(truths)} cases drawn; answers sealed, SHA-256 {sha}")
    units = [diagnosis_unit(benchmark, one) for one in truths if one["digest"] is not None]
    answers = benchmark.runner(code_versions()["diagnosis"]).run("diagnosing", units)
    known = open_sealed(sealed, sha)
    return sha, [
        {"case": case, "answer": answer, "truth": known[case]}
        for case, answer in zip(there, answers, strict=True)
    ]


def without_values(truth: dict[str, Any]) -> dict[str, Any]:
    """Return a truth without the values that its seed reproduces."""
    hidden = [{name: v for name, v in one.items() if name != "values"} for one in truth.get("truth", [])]
    kept = {name: value for name, value in truth.items() if name not in ("visited", "truth")}
    return {**kept, "truth": hidden}


def draw_all(benchmark: WideBenchmark, planned: Sequence[PlannedCase]) -> list[dict[str, Any]]:
    """Draw the cases without a result, and return all truths."""
    units = [drawing_unit(benchmark, one) for one in planned]
    return benchmark.runner(code_versions()["generator"]).run("drawing", units)


def drawing_unit(benchmark: WideBenchmark, planned: PlannedCase) -> Unit:
    """Return the unit that draws a case."""
    settings, folder = benchmark.settings, benchmark.recording(planned.case)
    arguments = {
        "case": planned.case,
        "names": list(planned.names),
        "engine": planned.engine,
        "seed": planned.seed,
        "matters": settings.matters,
        "each_matters": settings.each_matters,
        "attempts": settings.attempts,
    }
    return Unit(planned.case, draw_case, arguments, {"folder": folder}, folder)


def diagnosis_unit(benchmark: WideBenchmark, truth: dict[str, Any]) -> Unit:
    """Return the unit that diagnoses a case. It receives only the recording and its digest."""
    arguments = {"digest": truth["digest"], "limit": benchmark.settings.limit}
    return Unit(truth["case"], diagnose_case, arguments, {"folder": benchmark.recording(truth["case"])})


def code_versions() -> dict[str, str]:
    """Return the versions of the generator and of the diagnosis, including the native code."""
    return {"generator": versions.of_module("wide/case"), "diagnosis": versions.of_diagnosis()}
