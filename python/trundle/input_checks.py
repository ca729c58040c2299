"""Whether a recording can be diagnosed: what `trundle check` calls an error would be told as an effect."""

from __future__ import annotations

import os
from typing import Any, TypeAlias

from trundle import _native
from trundle._native import Recording, TrundleError

__all__ = ["require_usable", "warnings_of"]

PathLike: TypeAlias = "str | os.PathLike[str]"


def require_usable(recording: Recording | PathLike) -> list[str]:
    """Refuse a recording whose units, sign, axes, clocks or motion are surely wrong.

    A force of the wrong sign is answered well by a wheel that drives, degrees by a tracker that turns: no
    residual tells them from physics, so they are looked for before there is one.

    Parameters
    ----------
    recording : Recording or path

    Returns
    -------
    list of str
        What is doubtful, in words, the gravest first.

    Raises
    ------
    TrundleError
        With everything that is surely wrong, what to do about it, and where.
    """
    findings = _native.check(recording)
    wrong = [describe(finding) for finding in findings if finding["severity"] == "error"]
    if wrong:
        name = recording.name if isinstance(recording, Recording) else os.fspath(recording)
        raise TrundleError(f"{name}: " + "; ".join(wrong))
    return warnings_of(findings)


def warnings_of(findings: list[dict[str, Any]]) -> list[str]:
    """Return the warnings among the findings of a check, in words."""
    return [describe(finding) for finding in findings if finding["severity"] == "warning"]


def describe(finding: dict[str, Any]) -> str:
    """Return a finding in a line: where, what is seen, what to do."""
    where = "" if finding["episode"] is None else f"{finding['episode']}: "
    return f"{where}{finding['sentence']} ({finding['remedy']})"
