"""`trundle import --guess`: a map from the names of the columns, and the questions that remain."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trundle.cli.settings_pairs import parse_pairs, parse_value

if TYPE_CHECKING:
    from trundle.importers.guess import MapGuess, Question

__all__ = ["guess", "list_questions"]


def guess(source: Path, pairs: Sequence[str], *, ask: bool) -> MapGuess:
    """Guess the map of a source.

    Parameters
    ----------
    source : Path
        CSV file or folder.
    pairs : sequence of str
        Known keys of the map, "KEY=VALUE".
    ask : bool
        Ask on the terminal for missing keys, if standard input and output are terminals. An empty answer
        ends the questions.
    """
    from trundle.importers.guess import guess_from, read_table, set_key

    given = nested(pairs)
    table = read_table(source)
    found = guess_from(source, table, given)
    while ask and is_interactive() and found.questions:
        value = ask_for(found.questions[0], input)
        if value is None:
            break
        set_key(given, found.questions[0].key, value)
        found = guess_from(source, table, given)
    return found


def nested(pairs: Sequence[str]) -> dict[str, Any]:
    """Return the part of a map that "KEY=VALUE" pairs give, with keys such as "recording.wrench.sign"."""
    from trundle.importers.guess import set_key

    given: dict[str, Any] = {}
    for key, value in parse_pairs(pairs).items():
        set_key(given, key, value)
    return given


def is_interactive() -> bool:
    """Return whether a person can answer questions."""
    return sys.stdin.isatty() and sys.stdout.isatty()


def ask_for(question: Question, read_line: Callable[[str], str]) -> Any | None:
    """Return the answer to a question, or None if it is empty."""
    choices = "".join(f"\n  {number}  {choice}" for number, choice in enumerate(question.choices, 1))
    example = f" (such as {question.example})" if question.example and question.example != "NAME" else ""
    while True:
        text = read_line(f"{question.key}: {question.text}{example}{choices}\n> ").strip()
        if not text:
            return None
        if not question.choices:
            return parse_value(text)
        if text.isdigit() and 1 <= int(text) <= len(question.choices):
            text = question.choices[int(text) - 1]
        if text in question.choices:
            return parse_value(text) if text in ("true", "false") else text
        print(f"{text!r} is not one of {', '.join(question.choices)}")


def list_questions(found: MapGuess) -> str:
    """Return the missing keys as lines."""
    count = len(found.questions)
    head = f"{count} key{'s' * (count != 1)} of the map {'are' if count > 1 else 'is'} missing"
    return "\n".join([head, *(f"  {question}" for question in found.questions)])
