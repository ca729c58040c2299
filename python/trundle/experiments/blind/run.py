"""Run `trundle prove` from its settings file to its document."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from trundle.experiments.backends import Backend
from trundle.experiments.blind.benchmark import BlindBenchmark, run_benchmark
from trundle.experiments.blind.config import read
from trundle.experiments.blind.document import write_document
from trundle.recording import TrundleError

__all__ = ["prove"]


def prove(
    config: Path,
    which: str,
    work: Path,
    out: Path,
    *,
    backend: Backend,
    limits: bool = False,
    leave_out: bool = False,
    after_design: bool = False,
    fresh: bool = False,
    redraw: bool = False,
    quiet: bool = False,
) -> str:
    """Run the unfinished part of a blind benchmark, and write its document.

    Parameters
    ----------
    config : Path
        Settings file.
    which : str
        Range of seeds in the file.
    work : Path
        Folder of recordings.
    out : Path
        Folder of the document, of `proof/` (results) and of `images/`.
    backend : Backend
        Where cases are drawn and diagnosed.
    limits, leave_out, after_design : bool
        Run detection limits instead of the main benchmark; also diagnose without the true effect; also
        simulate the pushes that diagnoses request.
    fresh, redraw : bool
        Discard earlier results; or only write the document.
    quiet : bool
        Show no progress.

    Returns
    -------
    str
        Text of the document.
    """
    settings = read(config, which)
    name = config.stem if which == "report" else f"{config.stem}_{which}"
    if not redraw:
        part = f"{name}_limits" if limits else name
        proof = BlindBenchmark(part, settings, work / part, out / "proof", backend, quiet)
        if fresh:
            shutil.rmtree(proof.work, ignore_errors=True)
            for later in ("_without", "_after"):
                proof.file_of(later).unlink(missing_ok=True)
        run_benchmark(proof, limits=limits, leave_out=leave_out, after_design=after_design, tell=print_status)
    if not (out / "proof" / f"{name}.jsonl").exists() and redraw:
        raise TrundleError(f"{out / 'proof' / name}.jsonl: no results to draw: run without --redraw")
    return write_document(out, name)


def print_status(text: str) -> None:
    """Print a status line to standard error."""
    print(text, file=sys.stderr, flush=True)
