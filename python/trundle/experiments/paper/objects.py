"""Objects of the experiments as texts of `model.toml`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from trundle.experiments.paper.config import model_text
from trundle.recording import TrundleError
from trundle.settings import parse

__all__ = ["fit_model_text", "read_object", "title", "true_model_text"]

WHEEL = [{"kind": "viscous_wheel"}]


def read_object(folder: Path, name: str) -> dict[str, Any]:
    """Return `body`, `effect`, `radius` and `name` of an object, given as `file` or `file:configuration`.

    The default is the first configuration.
    """
    file, _, wanted = name.partition(":")
    path = folder / f"{file}.toml"
    found = parse(path)
    configurations = {one["name"]: one.get("effect", []) for one in found.get("configuration", [])}
    if wanted and wanted not in configurations:
        raise TrundleError(f"{path}: has no configuration '{wanted}'; it has {', '.join(configurations)}")
    chosen = wanted or next(iter(configurations), "")
    return {
        "name": found["name"],
        "body": found["body"],
        "effect": configurations.get(chosen, []),
        "radius": found.get("radius"),
    }


def true_model_text(thing: dict[str, Any]) -> str:
    """Return the true model of an object."""
    return model_text(thing["body"], thing["effect"])


def fit_model_text(thing: dict[str, Any], more: Sequence[str] = ()) -> str:
    """Return the paper's model (eq. 3): the object's shape, a mass and one wheel, all six values free.

    `more` are kinds of further effects.
    """
    body = {key: value for key, value in thing["body"].items() if key != "mass"}
    return model_text(body, [*WHEEL, *({"kind": kind} for kind in more)])


def title(name: str) -> str:
    """Return an object's name for a table: `office table, locked` for `office_table:locked`."""
    return name.replace("_", " ").replace(":", ", ")
