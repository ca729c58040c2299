"""A guessed map as a commented TOML file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import tomli_w

from trundle.atomic import write_text
from trundle.importers.guess.result import MapGuess, Question

__all__ = ["map_text", "write_map"]

COMMENT_COLUMN = 52


def write_map(guess: MapGuess, path: Path | str) -> Path:
    """Write a guessed map as a commented TOML file; missing keys are comments to complete.

    Parameters
    ----------
    guess : MapGuess
        As from `guess_map`.
    path : path
        The new file; an existing file is replaced atomically.

    Returns
    -------
    Path
        The file.

    Examples
    --------
    >>> guess = trundle.importers.guess_map("log.csv")
    >>> trundle.importers.write_map(guess, "map.toml").name
    'map.toml'
    """
    write_text(Path(path), map_text(guess))
    return Path(path)


def map_text(guess: MapGuess) -> str:
    """Return a guessed map as TOML, with the confidence and the basis of each key as comments.

    Examples
    --------
    >>> guess = trundle.importers.guess_map("log.csv")
    >>> "x_mm" in trundle.importers.map_text(guess)
    True
    """
    notes = {one.key: f"{one.confidence}: {one.basis}" for one in guess.assignments}
    settings, asked = guess.settings, {question.key: question for question in guess.questions}
    lines = [
        f"# Map of {guess.source.name}, for `trundle import SOURCE --map FILE --out DIR` (docs/import.md)"
    ]
    lines += ["# Comments state the confidence of a guess and what it rests on.", ""]
    plain = [key for key in settings if key not in ("columns", "recording", "times")]
    for key in plain:
        lines += _entry(key, settings[key], notes.get(key, ""), asked.pop(f"{key}.unit", None))
    lines += _questions(asked, [key for key in asked if key in ("time", "time.unit")], "")
    for table in ("times", "columns"):
        lines += _table(table, settings.get(table, {}), notes, asked)
    lines += _unused(guess.unused)
    return "\n".join([*lines, *_recording(settings["recording"], notes, asked)]) + "\n"


def _table(
    name: str, table: Mapping[str, Any], notes: Mapping[str, str], asked: dict[str, Question]
) -> list[str]:
    own = [key for key in asked if key.startswith(f"{name}.")]
    if not table and not own:
        return []
    lines = ["", f"[{name}]"]
    for key, value in table.items():
        where = f"{name}.{key}"
        lines += _entry(key, value, notes.get(where, ""), asked.pop(f"{where}.unit", None))
    return lines + _questions(asked, [key for key in own if key in asked], f"{name}.")


def _recording(
    recording: Mapping[str, Any], notes: Mapping[str, str], asked: dict[str, Question]
) -> list[str]:
    """Return the tables of `[recording]`, as in recording.toml."""
    lines = []
    plain = {key: value for key, value in recording.items() if not isinstance(value, Mapping)}
    if plain:
        lines += ["", "[recording]", *(f"{key} = {toml_value(value)}" for key, value in plain.items())]
    tables = [key for key, value in recording.items() if isinstance(value, Mapping)]
    for name in dict.fromkeys(["object", "wrench", *tables]):
        lines += _table(f"recording.{name}", recording.get(name, {}), notes, asked)
    # Optional keys that a log cannot contain.
    return [
        *lines,
        "",
        "# [recording.split]",
        '# held_out = ["episode_01"]     # optional: predicted, never fitted',
    ]


def _entry(key: str, value: object, note: str, unit: Question | None) -> list[str]:
    """Return one key with its comment, and the question about its unit."""
    line = f"{key} = {toml_value(value)}"
    lines = [f"{line:{COMMENT_COLUMN}}  # {note}".rstrip() if note else line]
    if unit is not None:
        lines.append(f"# MISSING: unit of {key} ({' or '.join(unit.choices)}): {unit.text}")
    return lines


def _questions(asked: dict[str, Question], keys: Iterable[str], prefix: str) -> list[str]:
    lines = []
    for key in list(keys):
        question = asked.pop(key)
        value = " or ".join(map(_quoted, question.choices)) or question.example
        lines += [f"# MISSING: {question.text}", f"# {key.removeprefix(prefix)} = {value}"]
    return lines


def _quoted(choice: str) -> str:
    return choice if choice in ("true", "false") else toml_value(choice)


def _unused(unused: Mapping[str, str]) -> list[str]:
    return (
        ["", "# Columns that are not used:", *(f"#   {name}: {why}" for name, why in unused.items())]
        if unused
        else []
    )


def toml_value(value: object) -> str:
    """Return a value as inline TOML."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {toml_value(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    return tomli_w.dumps({"x": value}).removeprefix("x = ").rstrip("\n")
