"""Checks of input and output paths before any work."""

from __future__ import annotations

import argparse
import difflib
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

__all__ = ["DIAGNOSIS", "RECORDING", "Input", "Output", "check_output", "check_paths", "declare"]


@dataclass(frozen=True)
class Input:
    """A path that a verb reads.

    Attributes
    ----------
    label : str
        Name of the argument, such as "RECORDING" or "--model".
    kind : {"recording", "log", "file", "any"}
        What it must be; "log" is a recording or a CSV file, and "any" is only checked for existence.
    content : str
        Content of a file in words, such as "a model file (model.toml)".
    """

    label: str
    kind: Literal["recording", "log", "file", "any"]
    content: str = ""


@dataclass(frozen=True)
class Output:
    """A path that a verb writes.

    Attributes
    ----------
    label : str
        Name of the argument, such as "--out".
    kind : {"file", "folder"}
        What is written.
    suffixes : tuple of str
        Allowed suffixes of a file; empty for any.
    marker : str
        File that identifies an earlier output, which is replaced. If empty, the folder's content is kept.
    content : str
        What is written, in words, such as "a diagnosis".
    """

    label: str
    kind: Literal["file", "folder"]
    suffixes: tuple[str, ...] = ()
    marker: str = ""
    content: str = ""


RECORDING = Output("--out", "folder", marker="recording.toml", content="a recording")
DIAGNOSIS = Output("--out", "folder", marker="diagnosis.json", content="a diagnosis")


def declare(parser: argparse.ArgumentParser, dest: str, path: Input | Output) -> None:
    """Declare an argument as a path, so that `check_paths` checks it before the verb runs."""
    parser.set_defaults(paths={**(parser.get_default("paths") or {}), dest: path})


def check_paths(args: argparse.Namespace) -> None:
    """Check all declared paths of a verb.

    Raises
    ------
    ValueError
        If an input does not exist or is something else, or an output cannot be written. The message names
        the argument, the path and the remedy.
    """
    declared: dict[str, Input | Output] = getattr(args, "paths", None) or {}
    inputs: dict[Path, str] = {}
    for dest, path in declared.items():
        if isinstance(path, Input):
            given = list(_paths(getattr(args, dest)))
            for each in given:
                check_input(each, path, given)
                inputs[each] = path.label
    for dest, path in declared.items():
        if isinstance(path, Output):
            for each in _paths(getattr(args, dest)):
                check_output(each, path, inputs)


def _paths(value: object) -> Iterator[Path]:
    if isinstance(value, Path):
        yield value
    elif isinstance(value, list):
        yield from (each for each in value if isinstance(each, Path))


def check_input(path: Path, wanted: Input, together: Iterable[Path] = ()) -> None:
    """Check that an input exists and is of the right kind.

    Parameters
    ----------
    path : Path
    wanted : Input
    together : iterable of Path
        All values of the argument: a name with a space that is not quoted arrives as several.
    """
    if not path.exists():
        joined = Path(" ".join(map(str, together)))
        hint = f"; quote the name: '{joined}'" if joined != path and joined.exists() else _nearest(path)
        raise ValueError(f"{wanted.label} = {path}: no such file or folder{hint}")
    is_log = wanted.kind == "log" and path.is_file() and path.suffix.lower() == ".csv"
    if wanted.kind in ("recording", "log") and not is_log and not (path / "recording.toml").is_file():
        raise ValueError(f"{wanted.label} = {path}: {_not_a_recording(path)}")
    if wanted.kind == "file" and path.is_dir():
        raise ValueError(f"{wanted.label} = {path}: {_not_a_file(path, wanted)}")


def _nearest(path: Path) -> str:
    """Return a hint with a similar name in the same folder."""
    if not path.parent.is_dir():
        return f"; the folder {path.parent} does not exist"
    names = [each.name for each in path.parent.iterdir() if not each.name.startswith(".")]
    near = difflib.get_close_matches(path.name, names, n=1)
    return f"; did you mean {path.with_name(near[0])}?" if near else ""


def _not_a_recording(path: Path) -> str:
    """Return why a path is not a recording, and what to do."""
    if path.name == "recording.toml":
        return f"is a file; give the folder that contains it: {path.parent}"
    if path.is_dir():
        if (path / "diagnosis.json").is_file():
            return "is a diagnosis, not a recording; give the folder that was diagnosed"
        inner = sorted(each.parent.name for each in path.glob("*/recording.toml"))
        if inner:
            return f"has no recording.toml, but contains recordings; give one, such as {path / inner[0]}"
        if any(path.glob("*.csv")):
            return f"has no recording.toml; import the CSV files: `trundle import {path} --guess --out DIR`"
        return "has no recording.toml; a recording is a folder with recording.toml and one table per episode"
    if path.suffix.lower() in (".csv", ".mcap", ".mat", ".db3"):
        guess = " --guess" if path.suffix.lower() == ".csv" else ""
        return f"is a file, not a recording; import it: `trundle import {path}{guess} --out DIR`"
    return (
        "is a file; a recording is a folder with recording.toml. If this is a model, give it with --model "
        "(are the arguments swapped?)"
    )


def _not_a_file(path: Path, wanted: Input) -> str:
    """Return why a folder is not the wanted file, and what to do."""
    if (path / "recording.toml").is_file():
        return f"is a recording, but {wanted.label} is {wanted.content} (are the arguments swapped?)"
    inner = path / "model.toml"
    hint = f"; did you mean {inner}?" if "model" in wanted.content and inner.is_file() else ""
    return f"is a folder, but {wanted.label} is {wanted.content}{hint}"


def check_output(path: Path, wanted: Output, inputs: dict[Path, str]) -> None:
    """Check that an output can be written.

    Parameters
    ----------
    path : Path
    wanted : Output
    inputs : dict of Path to str
        Inputs of the verb with the names of their arguments, which must not be replaced.
    """
    label = f"{wanted.label} {path}"
    for source, name in inputs.items():
        if os.path.realpath(source) == os.path.realpath(path):
            raise ValueError(f"{label}: is the input {name}; give another {wanted.kind} with {wanted.label}")
    if wanted.kind == "file":
        _check_file(path, wanted, label)
    else:
        _check_folder(path, wanted, label)
    _check_writable(path, label)


def _check_file(path: Path, wanted: Output, label: str) -> None:
    if path.is_dir():
        raise ValueError(f"{label}: is a folder; give a file, such as {path / ('NAME' + _suffix(wanted))}")
    if wanted.suffixes and path.suffix.lower() not in wanted.suffixes:
        allowed = " or ".join(wanted.suffixes)
        raise ValueError(
            f"{label}: unknown suffix {path.suffix!r}; {wanted.content} is written as {allowed}, such as "
            f"{path.with_suffix(_suffix(wanted))}"
        )


def _suffix(wanted: Output) -> str:
    return wanted.suffixes[0] if wanted.suffixes else ""


def _check_folder(path: Path, wanted: Output, label: str) -> None:
    if path.exists() and not path.is_dir():
        raise ValueError(f"{label}: is a file; give a folder")
    if wanted.marker and path.is_dir() and not (path / wanted.marker).exists() and any(path.iterdir()):
        raise ValueError(f"{label}: is not empty and not {wanted.content}; give another folder")


def _check_writable(path: Path, label: str) -> None:
    """Check that the nearest existing folder above `path` can be written; missing folders are created."""
    parent = path.absolute().parent
    while not parent.exists() and parent != parent.parent:
        parent = parent.parent
    if not parent.is_dir():
        raise ValueError(f"{label}: {parent} is a file, not a folder; give another path")
    if not os.access(parent, os.W_OK | os.X_OK):
        raise ValueError(f"{label}: no permission to write in {parent}; give another path")
    if path.exists() and not os.access(path, os.W_OK):
        raise ValueError(f"{label}: no permission to replace it; give another path")
