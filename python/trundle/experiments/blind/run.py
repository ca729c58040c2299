"""Run `trundle prove` from its settings file to its page."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

from trundle.experiments.blind.benchmark import Benchmark, code_versions, run_benchmark
from trundle.experiments.blind.page import write_page
from trundle.experiments.blind.result_files import ResultFiles
from trundle.experiments.blind.settings import Settings, read
from trundle.experiments.execution import Execution
from trundle.recording import TrundleError

__all__ = ["prove"]

RESULT_FOLDERS = {"furniture": "proof", "wide": "wide", "mechanism": "mechanism"}
"""Folders of the results, by generator."""


def prove(
    config: Path,
    which: str,
    execution: Execution,
    *,
    limits: bool = False,
    leave_out: bool = False,
    after_design: bool = False,
    shares: int | None = None,
) -> str:
    """Run the unfinished part of a blind benchmark, and write its page.

    Parameters
    ----------
    config : Path
        Settings file.
    which : str
        A range of the file.
    execution : Execution
        Recordings are in its folder `work`. The page, `proof/`, `wide/` or `mechanism/` (answers, sealed
        truth, costs) and `images/` are in its folder `out`. With `fresh` earlier results are discarded.
    limits, leave_out, after_design : bool
        Run detection limits instead of the main benchmark; also diagnose without the true effect; also
        simulate the pushes that diagnoses request. Only for furniture.
    shares : int, optional
        Largest number of shares to run: the first of those without results of this code version in `out`. By
        default all of them. Only for a range with shares.

    Returns
    -------
    str
        The page, of the shares that have results.
    """
    settings = read(config, which)
    options = {"limits": limits, "leave-one-out": leave_out, "after-design": after_design}
    check_options(config, settings, options, shares)
    name = config.stem if which == "report" else f"{config.stem}_{which}"
    folder = execution.out / RESULT_FOLDERS[settings.generator]
    files = {
        one: ResultFiles(folder, name if one.share is None else f"{name}_{one.share:02}")
        for one in settings.parts()
    }
    if not execution.redraw:
        part = execution.work / (f"{config.stem}_{settings.parent}" + "_limits" * limits)
        if execution.fresh:
            shutil.rmtree(part, ignore_errors=True)
        waiting = [
            one for one in files if execution.fresh or one.share is None or not is_done(one, files[one])
        ]
        for one in waiting[:shares]:
            mine = ResultFiles(folder, f"{name}_limits") if limits else files[one]
            if execution.fresh:
                mine.remove("_without", "_after")
            benchmark = Benchmark(one, mine, replace(execution, work=part, fresh=False), limits)
            run_benchmark(benchmark, leave_out=leave_out, after_design=after_design)
    return write_page(execution.out, name, list(files.values()))


def is_done(settings: Settings, files: ResultFiles) -> bool:
    """Return whether a share has results of these settings and this code."""
    return files.depend_on(settings.plain(), code_versions(settings))


def check_options(config: Path, settings: Settings, options: dict[str, bool], shares: int | None) -> None:
    """Raise an error if an option does not apply to a benchmark."""
    if options["limits"] and options["after-design"]:
        raise TrundleError("--after-design applies only to the main benchmark: remove --limits")
    if settings.generator == "furniture" and shares is not None:
        raise TrundleError(f"--shares applies only to a benchmark with shares, and {config} has none")
    if shares is not None and shares < 1:
        raise TrundleError(f"--shares {shares}: must be at least 1")
    given = [name for name, value in options.items() if value]
    if settings.generator != "furniture" and given:
        raise TrundleError(
            f"--{given[0]} does not apply to a {settings.generator} benchmark, such as {config}"
        )
