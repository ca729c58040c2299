"""Findings: suspicious properties of a recording, each with a remedy."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal, overload

from trundle.display import Card, Displayed

__all__ = ["Finding", "Findings"]


@dataclass(frozen=True, repr=False)
class Finding(Displayed):
    """A suspicious property of a recording.

    Attributes
    ----------
    kind : str
        Category, such as "units", "sign", "clocks" or "tare".
    severity : {"error", "warning", "note"}
        Whether results from this recording would be wrong, may be wrong, or are as expected.
    sentence : str
        What is wrong, with numbers.
    remedy : str
        How to correct it.
    episode : str or None
        The episode; None if the finding concerns the whole recording.

    Examples
    --------
    >>> finding = trundle.Finding("sign", "error", "the force opposes the motion", "change [wrench] sign")
    >>> finding
    <trundle.Finding error (sign): the force opposes the motion>
      remedy  change [wrench] sign
    """

    kind: str
    severity: Literal["error", "warning", "note"]
    sentence: str
    remedy: str
    episode: str | None = None

    def __str__(self) -> str:
        """Return one line: episode, observation, remedy."""
        where = "" if self.episode is None else f"{self.episode}: "
        return f"{where}{self.sentence} ({self.remedy})"

    def to_dict(self) -> dict[str, Any]:
        """Return the fields, as in the output of ``trundle check --json``."""
        return asdict(self)

    def _card(self) -> Card:
        where = "" if self.episode is None else f" {self.episode}:"
        title = f"trundle.Finding {self.severity} ({self.kind}):{where} {self.sentence}"
        return Card(title, [("remedy", self.remedy)])


class Findings(Sequence[Finding], Displayed):
    """Findings of a check, most severe first: a sequence.

    Examples
    --------
    >>> findings = trundle.check(recording)
    >>> [finding.kind for finding in findings if finding.severity == "error"]
    []
    >>> findings.errors
    []
    """

    def __init__(self, findings: Iterable[Finding] = ()) -> None:
        self._findings = tuple(findings)

    @overload
    def __getitem__(self, index: int) -> Finding: ...
    @overload
    def __getitem__(self, index: slice) -> Findings: ...
    def __getitem__(self, index: int | slice) -> Finding | Findings:
        """Return a finding, or the findings of a slice."""
        return Findings(self._findings[index]) if isinstance(index, slice) else self._findings[index]

    def __iter__(self) -> Iterator[Finding]:
        """Iterate over the findings, most severe first."""
        return iter(self._findings)

    def __len__(self) -> int:
        """Return the number of findings."""
        return len(self._findings)

    def __eq__(self, other: object) -> bool:
        """Whether the findings are the same."""
        return self._findings == other._findings if isinstance(other, Findings) else NotImplemented

    def __hash__(self) -> int:
        """Return the hash of the findings."""
        return hash(self._findings)

    @property
    def errors(self) -> list[Finding]:
        """Findings because of which results from this recording would be wrong."""
        return [finding for finding in self if finding.severity == "error"]

    @property
    def warnings(self) -> list[Finding]:
        """Findings because of which results from this recording may be wrong."""
        return [finding for finding in self if finding.severity == "warning"]

    def _card(self) -> Card:
        if not self:
            return Card("trundle.Findings: none: units, sign, axes, clocks, tare and motion look right")
        count = len(self) - len(self.errors) - len(self.warnings)
        title = f"trundle.Findings: {len(self.errors)} errors, {len(self.warnings)} warnings, {count} notes"
        rows = [
            (f"{f.severity} ({f.kind})", (f.episode or "") + (": " if f.episode else "") + f.sentence)
            for f in self
        ]
        return Card(title, rows)
