"""Checks of a recording before a diagnosis."""

from __future__ import annotations

import os
from typing import TypeAlias

from trundle._native import JointRecording, Recording, TrundleError, read
from trundle.findings import Finding, Findings
from trundle.inspection import check

__all__ = ["held_out_findings", "name_of", "require_usable"]

PathLike: TypeAlias = "str | os.PathLike[str]"


def name_of(recording: Recording | JointRecording | PathLike) -> str:
    """Return the name of a recording, or its path, for messages."""
    return recording.name if isinstance(recording, Recording | JointRecording) else os.fspath(recording)


def require_usable(recording: Recording | JointRecording | PathLike) -> list[str]:
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
    errors = [*findings.errors, *filter(_is_in_degrees, findings.warnings)]
    if errors:
        raise TrundleError(f"{name_of(recording)}: " + "; ".join(map(str, errors)))
    return [str(finding) for finding in findings.warnings]


def _is_in_degrees(finding: Finding) -> bool:
    """Whether a finding is that angles of joints are in degrees, which no model can fit."""
    return finding.kind == "units" and "degrees" in finding.sentence


def held_out_findings(recording: Recording | JointRecording | PathLike) -> Findings:
    """Return a finding if no episode is held out."""
    data = _opened(recording)
    if data.metadata.get("split", {}).get("held_out"):
        return Findings()
    names = list(data)
    motions = "motions" if isinstance(data, JointRecording) else "pushes"
    remedy = f'add [split] held_out = ["{names[-1]}"] to recording.toml'
    if len(names) == 1:
        remedy = f"record more {motions}, and {remedy.replace(names[-1], 'NAME')}"
    sentence = f"no episode is held out, so the error of a model on new {motions} is not measured"
    return Findings([Finding("held_out", "warning", sentence, remedy)])


def _opened(recording: Recording | JointRecording | PathLike) -> Recording | JointRecording:
    return recording if isinstance(recording, Recording | JointRecording) else read(recording)
