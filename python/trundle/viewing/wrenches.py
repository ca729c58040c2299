"""Wrenches of the missing effects along the recorded motion, from their laws."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import tomli_w

from trundle._native import Laws, Model, effects
from trundle.export.mjcf import parse_model
from trundle.viewing.scene import Floats

__all__ = ["added_laws", "law_wrenches"]

Table = Mapping[str, Any]


def added_laws(model: Model, answer: Mapping[str, Any]) -> dict[str, Laws]:
    """Return the laws that a diagnosis added to a model and that act on the object, by effect.

    Parameters
    ----------
    model : Model
        The extended model.
    answer : mapping
        The content of diagnosis.json.

    Returns
    -------
    dict
        Laws of one effect each; "discrepancy" is the learnt wrench of an unexplained recording. Effects of
        the instruments exert no wrench and are omitted.
    """
    catalogue = {law["kind"]: law for law in effects()}
    tables = parse_model(model)
    nominal = count_nominal(answer["nominal"])
    found: dict[str, Laws] = {}
    for effect in tables.get("effect", ()):
        kind = effect["kind"]
        if nominal[kind] > 0:
            nominal[kind] -= 1
        elif catalogue[kind]["acting"] == "object":
            name = catalogue[kind]["effect"]
            found[name if name not in found else f"{name}_{len(found) + 1}"] = one_law(
                tables, effect=[effect]
            )
    unnamed = tables.get("unnamed")
    if unnamed is not None and unnamed.get("axes") != "reading":
        found["discrepancy"] = one_law(tables, unnamed=unnamed)
    return found


def count_nominal(nominal: Mapping[str, Mapping[str, Any]]) -> Counter[str]:
    """Return how many effects of each kind the nominal model contains, from the names of its parameters."""
    names = {name.rpartition(".")[0] for values in nominal.values() for name in values if "." in name}
    return Counter(re.sub(r"_\d+$", "", name) for name in names if name != "body")


def one_law(tables: Table, **part: Any) -> Laws:
    """Return the laws of a model with the body and one other part."""
    kept = {key: tables[key] for key in ("format", "body")}
    return Laws(Model.from_toml(tomli_w.dumps({**kept, **part})))


def law_wrenches(
    laws: Laws, motion: Mapping[str, Floats], applied: Floats, contact: float, episode: int
) -> Floats:
    """Return the wrench of laws along a motion.

    Parameters
    ----------
    laws : Laws
    motion : mapping
        `t` (n,), `pose` and `twist` (n, 3), as `trundle.smooth` returns them.
    applied : (n, 3) array
        Measured wrench, object axes about its origin, N, N, N·m. It drives inner states of the laws.
    contact : float
        Time of first contact, s.
    episode : int
        Index of the episode in the recording.

    Returns
    -------
    (n, 3) array
        Wrench on the object, object axes about its origin, N, N, N·m.
    """
    inner: Iterable[float] = laws.starts
    steps = np.diff(motion["t"], append=motion["t"][-1:])
    rows = []
    clock = {"contact": contact, "episode": float(episode)}
    for t, dt, pose, twist, force in zip(
        motion["t"], steps, motion["pose"], motion["twist"], applied, strict=True
    ):
        inner = list(inner)
        rows.append(laws.wrench(pose, twist, t, inner=inner, **clock))
        if inner and dt > 0.0:
            inner = laws.step(pose, twist, force, dt, t, inner=inner, **clock)[2]
    return np.array(rows, dtype=float).reshape(-1, 3)
