"""Result of a guess: assigned columns, questions, unused columns and the map."""

from __future__ import annotations

import shlex
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from trundle.display import Card, Displayed

__all__ = ["Assignment", "Confidence", "MapGuess", "Question"]

Confidence = Literal["high", "medium", "given"]


@dataclass(frozen=True)
class Assignment:
    """A guessed key of the map.

    Attributes
    ----------
    key : str
        Key of the map, such as "time" or "columns.object_x".
    value : object
        Its value, as in a map file.
    confidence : {"high", "medium", "given"}
        "high": the name states it; "medium": it rests on a default, on the values or on the other columns;
        "given": by the caller.
    basis : str
        What the guess rests on.
    """

    key: str
    value: Any
    confidence: Confidence
    basis: str


@dataclass(frozen=True)
class Question:
    """A key of the map that cannot be guessed.

    Attributes
    ----------
    key : str
        Key of the map, such as "recording.object.footprint".
    text : str
        What is missing or ambiguous.
    choices : tuple of str
        Possible values; empty if any value of the right type is possible.
    example : str
        A value in TOML.
    """

    key: str
    text: str
    choices: tuple[str, ...] = ()
    example: str = ""

    def __str__(self) -> str:
        """Return the question as one line: key, text, an option that answers it."""
        return f"{self.key}: {self.text}; answer with --set {self.key}={self.answer}"

    @property
    def answer(self) -> str:
        """An example of an answer for a shell, or all choices."""
        return "|".join(map(shlex.quote, self.choices)) if self.choices else shlex.quote(self.example)

    @property
    def hint(self) -> str:
        """The choices or the example in words."""
        return f" ({' or '.join(self.choices)})" if self.choices else f", such as {self.example}"


@dataclass(frozen=True, repr=False)
class MapGuess(Displayed):
    """A guessed map of CSV files.

    Attributes
    ----------
    source : Path
        The file or folder.
    settings : dict
        The map, as `trundle.importers.read` accepts it. It is complete if there are no questions.
    assignments : list of Assignment
        Guessed keys with their confidence.
    questions : list of Question
        Missing and ambiguous keys.
    unused : dict of str to str
        Columns of the file that the map does not use, with the reason.

    Examples
    --------
    >>> guess = trundle.importers.guess_map("log.csv")
    >>> guess.is_complete
    False
    """

    source: Path
    settings: dict[str, Any]
    assignments: list[Assignment]
    questions: list[Question]
    unused: dict[str, str] = field(default_factory=dict)

    @property
    def is_complete(self) -> bool:
        """Whether the map can be used without answers."""
        return not self.questions

    def _card(self) -> Card:
        state = "complete" if self.is_complete else f"{len(self.questions)} keys are missing"
        title = f"trundle.importers.MapGuess of {self.source}: {len(self.assignments)} keys, {state}"
        return Card(title, [(question.key, question.text) for question in self.questions])
