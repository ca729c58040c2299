"""Read the files of the paper's experiments."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomli_w

from trundle.experiments.paper.experiment import Options
from trundle.recording import TrundleError
from trundle.settings import parse_format

__all__ = ["model_text", "read", "select_settings"]

FORMAT = "trundle-paper/1"


def read(path: Path, known: Mapping[str, type | tuple[type, ...]]) -> dict[str, Any]:
    """Read an experiment's file.

    Parameters
    ----------
    path : Path
        The file.
    known : mapping
        Every required key and the type of its value. Besides these, only `quick` is allowed: a table of the
        keys that a quick run replaces.

    Raises
    ------
    TrundleError
        If a key is missing, unknown, or of another type.
    """
    found = parse_format(path, FORMAT, "; give its folder with --configs")
    quick = found.pop("quick", {})
    for name in [*found, *quick]:
        if name not in known:
            raise TrundleError(f"{path}: unknown key '{name}'; known are {', '.join(known)}, quick")
    for name, kind in known.items():
        if name not in found:
            raise TrundleError(f"{path}: the key '{name}' is missing")
        if not isinstance(quick.get(name, found[name]), kind):
            raise TrundleError(f"{path}: '{name}' has the wrong type")
    return {**found, "quick": quick}


def select_settings(found: Mapping[str, Any], options: Options) -> dict[str, Any]:
    """Return the settings of a full or a quick run, with the number of seeds of the command line."""
    replaced = found["quick"] if options.quick else {}
    kept = {name: replaced.get(name, value) for name, value in found.items() if name != "quick"}
    return kept if options.seeds is None else {**kept, "seeds": options.seeds}


def model_text(body: Mapping[str, Any], effects: list[dict[str, Any]]) -> str:
    """Return the text of a `model.toml`."""
    return tomli_w.dumps({"format": "trundle-model/1", "body": dict(body), "effect": effects})
