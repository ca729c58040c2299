"""Checks of a recording before a diagnosis."""

from __future__ import annotations

import os
from typing import Any, TypeAlias

from trundle import _native
from trundle._native import Recording, TrundleError

__all__ = ["describe", "held_out_findings", "require_usable", "warnings_of"]

PathLike: TypeAlias = "str | os.PathLike[str]"


def require_usable(recording: Recording | PathLike) -> list[str]:
    """Refuse a recording whose units, sign, axes, clocks or motion are certainly wrong.

    A diagnosis cannot find such errors: an effect of the catalogue may fit a wrong sign or a wrong unit well.

    Parameters
    ----------
    recording : Recording or path

    Returns
    -------
    list of str
        Warnings, most severe first.

    Raises
    ------
    TrundleError
        If `trundle.check` finds an error; the message lists all errors with their remedies.
    """
    findings = _native.check(recording)
    wrong = [describe(finding) for finding in findings if finding["severity"] == "error"]
    if wrong:
        name = recording.name if isinstance(recording, Recording) else os.fspath(recording)
        raise TrundleError(f"{name}: " + "; ".join(wrong))
    return warnings_of(findings)


def held_out_findings(recording: Recording | PathLike) -> list[dict[str, Any]]:
    """Return a finding if no episode is held out, in the form of `trundle.check`."""
    data = recording if isinstance(recording, Recording) else _native.read(recording)
    if data.metadata.get("split", {}).get("held_out"):
        return []
    names = list(data.episodes)
    remedy = f'add [split] held_out = ["{names[-1]}"] to recording.toml'
    if len(names) == 1:
        remedy = f"record more pushes, and {remedy.replace(names[-1], 'NAME')}"
    sentence = "no episode is held out, so the error of a model on new pushes is not measured"
    return [
        {"kind": "held_out", "severity": "warning", "episode": None, "sentence": sentence, "remedy": remedy}
    ]


def warnings_of(findings: list[dict[str, Any]]) -> list[str]:
    """Return the warnings among the findings of `trundle.check` as sentences."""
    return [describe(finding) for finding in findings if finding["severity"] == "warning"]


def describe(finding: dict[str, Any]) -> str:
    """Return a finding as one line: episode, observation, remedy."""
    where = "" if finding["episode"] is None else f"{finding['episode']}: "
    return f"{where}{finding['sentence']} ({finding['remedy']})"
