"""How a command runs an experiment: its folders, its backend, and what it keeps of earlier runs."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from trundle.experiments import versions
from trundle.experiments.backends import Backend, Local
from trundle.experiments.runner import Runner, Unit

__all__ = ["Execution"]


@dataclass(frozen=True)
class Execution:
    """Options of the commands that run an experiment.

    Attributes
    ----------
    work : Path
        Folder of finished units, from which an interrupted experiment continues.
    out : Path
        Folder of the document, of the results and of `images/`.
    backend : Backend
        Where units run.
    fresh : bool
        Discard finished units.
    redraw : bool
        Run no unit; write the document from existing results.
    quiet : bool
        Show no progress.
    """

    work: Path
    out: Path
    backend: Backend = field(default_factory=Local)
    fresh: bool = False
    redraw: bool = False
    quiet: bool = False

    def run(self, name: str, label: str, units: Sequence[Unit], version: str | None = None) -> list[Any]:
        """Run the units of an experiment that have no result, and return the results of all, in order.

        `version` is that of the code on which they depend, by default of the whole package.
        """
        store = self.work / name
        if self.fresh:
            shutil.rmtree(store, ignore_errors=True)
        return Runner(store, version or versions.of_package(), self.backend, self.quiet).run(label, units)
