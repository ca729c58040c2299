"""Checks of a recording before a diagnosis."""

from __future__ import annotations

import os
from typing import TypeAlias

from trundle._native import Recording, TrundleError, read
from trundle.findings import Finding, Findings
from trundle.inspection import check

__all__ = ["held_out_findings", "require_usable"]

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
    findings = check(recording)
    if findings.errors:
        name = recording.name if isinstance(recording, Recording) else os.fspath(recording)
        raise TrundleError(f"{name}: " + "; ".join(map(str, findings.errors)))
    return [str(finding) for finding in findings.warnings]


def held_out_findings(recording: Recording | PathLike) -> Findings:
    """Return a finding if no episode is held out."""
    data = recording if isinstance(recording, Recording) else read(recording)
    if data.metadata.get("split", {}).get("held_out"):
        return Findings()
    names = list(data)
    remedy = f'add [split] held_out = ["{names[-1]}"] to recording.toml'
    if len(names) == 1:
        remedy = f"record more pushes, and {remedy.replace(names[-1], 'NAME')}"
    sentence = "no episode is held out, so the error of a model on new pushes is not measured"
    return Findings([Finding("held_out", "warning", sentence, remedy)])
