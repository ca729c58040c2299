"""Inspection of recordings: statistics, checks, tared and transformed wrenches, smoothed motion."""

from __future__ import annotations

import os
from typing import Any, TypeAlias, overload

from trundle import _native
from trundle._native import JointRecording, Recording, prepare, smooth
from trundle.findings import Finding, Findings
from trundle.joint_summary import JointSummary
from trundle.summary import RecordingSummary

__all__ = ["check", "inspect", "prepare", "smooth"]

PathLike: TypeAlias = "str | os.PathLike[str]"


def check(recording: Recording | JointRecording | PathLike, *, mjcf: PathLike | None = None) -> Findings:
    """Check a recording for mistakes, without simulating it, as ``trundle check`` does.

    Parameters
    ----------
    recording : Recording, JointRecording or path
        The recording, its folder, or a CSV log of joints: see `trundle.diagnose`.
    mjcf : path, optional
        The MJCF or URDF file of a CSV log, which names its joints. Without it, they are all those that have
        columns.

    Returns
    -------
    Findings
        A sequence of `Finding`, most severe first: units, signs, axes, clocks, tare and excitation. For
        joints also the order of columns, wrapped angles, quantisation, saturation, encoders.

    Raises
    ------
    TrundleError
        If the recording cannot be read, or `mjcf` is given with another recording than a CSV log.

    Examples
    --------
    >>> for finding in trundle.check(recording):
    ...     print(finding.severity, finding.kind, finding.remedy)
    >>> trundle.check(recording).errors
    []
    """
    from trundle.joint_diagnosis.log import open_log

    log = open_log(recording, mjcf)
    found = _native._check(recording if log is None else log)
    return Findings(Finding(**one) for one in found)


@overload
def inspect(recording: Recording) -> RecordingSummary: ...
@overload
def inspect(recording: JointRecording) -> JointSummary: ...
@overload
def inspect(recording: PathLike) -> RecordingSummary | Any: ...
def inspect(recording: Recording | JointRecording | PathLike) -> RecordingSummary | JointSummary:
    """Summarise a recording in numbers, as ``trundle info`` does.

    Parameters
    ----------
    recording : Recording, JointRecording or path
        The recording, or its folder.

    Returns
    -------
    RecordingSummary or JointSummary
        Noise and mass, and for each episode the rates, gaps, numbers of masked samples, ranges of the tared
        wrench, travel and speed. For joints the noise, and for each episode and joint the rates, ranges and
        the largest speed.

    Raises
    ------
    TrundleError
        If the recording cannot be read, or a raw reading cannot be tared.

    Examples
    --------
    >>> summary = trundle.inspect(recording)
    >>> [episode.name for episode in summary.episodes if episode.held_out]
    ['episode_02']
    """
    found = _native._inspect(recording)
    return JointSummary.parse(found) if "joints" in found else RecordingSummary.parse(found)
