"""The result of a diagnosis of joints."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from trundle import _native
from trundle._native import JointRecording
from trundle._types import JointAnswer
from trundle.atomic import atomic_folder
from trundle.display import Card, Displayed

if TYPE_CHECKING:
    import os

    from trundle.joint_diagnosis.held_out import Path as MotionPath
    from trundle.mechanism import MechanismModel

__all__ = ["ANSWER_FILE", "JointDiagnosis"]

ANSWER_FILE = "diagnosis.json"
"""File that identifies a folder as a diagnosis."""


@dataclass(frozen=True, repr=False)
class JointDiagnosis(Displayed):
    """Result of a diagnosis of a recording of joints.

    Attributes
    ----------
    answer : dict
        The content of ``diagnosis.json``.
    model : MechanismModel
        The mechanism with refitted nominal values and the missing effects (``trundle-model/2``).
    report : str
        ``report.html``: one page that needs no network and works without scripts.
    predictions : dict
        Open-loop simulation of each held-out episode: see `trundle.joint_diagnosis.held_out.Path`.
    recording : JointRecording
        The recording; for a CSV log its note `columns` states which column became which stream.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(0, 10, 0.01)
    >>> q, a = np.sin(2 * t) + 0.3 * np.sin(5.3 * t), -4 * np.sin(2 * t) - 8.427 * np.sin(5.3 * t)
    >>> v = 2 * np.cos(2 * t) + 1.59 * np.cos(5.3 * t)
    >>> columns = {"t": t, "q_arm": q, "effort_arm": 0.1 * a + 0.05 * v + 0.4 * np.sign(v)}
    >>> metadata = {"format": "trundle-recording/2", "name": "bench"}
    >>> metadata["mechanism"] = {"axis": "hinge", "joints": ["arm"]}
    >>> diagnosis = trundle.diagnose(trundle.JointRecording(metadata, {"one": columns}))
    >>> diagnosis.missing
    ['joint_dry_friction:arm']
    """

    answer: JointAnswer
    model: MechanismModel
    report: str
    predictions: dict[str, MotionPath]
    recording: JointRecording

    @property
    def verdict(self) -> str:
        """One of "consistent", "reparameterised", "explained" and "unexplained"."""
        return str(self.answer["verdict"])

    @property
    def missing(self) -> list[str]:
        """Missing effects with their joint or body, largest contribution first."""
        return [":".join([one["effect"], *(one["where"] or {}).values()]) for one in self.answer["missing"]]

    def write(self, folder: str | os.PathLike[str]) -> Path:
        """Write ``diagnosis.json``, ``report.html``, ``model.toml`` and ``predictions.parquet``.

        Parameters
        ----------
        folder : path
            Created, or replaced atomically if it contains an earlier diagnosis.

        Returns
        -------
        Path
            The folder.

        Raises
        ------
        TrundleError
            If the folder contains anything else, or pyarrow is missing.
        """
        with atomic_folder(Path(folder), ANSWER_FILE, "a diagnosis") as partial:
            text = json.dumps(self.answer, indent=2, ensure_ascii=False, allow_nan=False)
            (partial / ANSWER_FILE).write_text(f"{text}\n", encoding="utf-8")
            (partial / "report.html").write_text(self.report, encoding="utf-8")
            (partial / "model.toml").write_text(self.model.to_toml(), encoding="utf-8")
            _write_predictions(partial / "predictions.parquet", self.predictions, self.model.mechanism.joints)
        return Path(folder)

    def _card(self) -> Card:
        from trundle.display.results import joint_diagnosis_card

        return joint_diagnosis_card(self.answer)


def _write_predictions(path: Path, predictions: dict[str, MotionPath], joints: list[str]) -> None:
    """Write the columns `episode`, `t`, `scored`, and three for each joint."""
    columns: dict[str, Any] = {"episode": [], "t": np.empty(0), "scored": np.empty(0, bool)}
    columns |= {f"{side}_q_{joint}": np.empty(0) for joint in joints for side in SIDES}
    for name, own in predictions.items():
        columns["episode"] += [name] * len(own.t)
        columns["t"] = np.r_[columns["t"], own.t]
        columns["scored"] = np.r_[columns["scored"], np.ones(len(own.t), bool)]
        for side in SIDES:
            q = getattr(own, side)
            q = np.full(own.observed.shape, np.nan) if q is None else q
            for k, joint in enumerate(joints):
                key = f"{side}_q_{joint}"
                columns[key] = np.r_[columns[key], q[:, k]]
    _native._write_table(path, list(columns.items()))


SIDES = ("observed", "before", "after")
"""Recorded positions, and simulated ones."""
