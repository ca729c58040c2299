"""Choice of episodes to draw, and open-loop simulations of a recording."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from trundle._native import _pushed
from trundle.inspection import prepare
from trundle.model import Model
from trundle.picture import outlines
from trundle.prediction import predict
from trundle.recording import Recording, TrundleError
from trundle.report.series import Series

__all__ = [
    "PathLike",
    "choose",
    "is_on_rail",
    "open_loop",
    "quasi_static_note",
    "read_recording",
    "short_names",
]

PathLike: TypeAlias = "str | os.PathLike[str]"


def read_recording(given: Recording | PathLike) -> Recording:
    """Return a recording, read from its folder if a path is given."""
    return _pushed(given)


def choose(names: Sequence[str], wanted: str | Sequence[str] | None, of: str) -> list[str]:
    """Return the wanted names, or all of them for None.

    Parameters
    ----------
    names : sequence of str
        Names of the episodes that exist.
    wanted : str or sequence of str, optional
        One name or several.
    of : str
        What they are episodes of, for the message.

    Raises
    ------
    TrundleError
        If an episode does not exist, or none is wanted.
    """
    if wanted is None:
        return list(names)
    chosen = [wanted] if isinstance(wanted, str) else list(wanted)
    for name in chosen:
        if name not in names:
            raise TrundleError(f"no episode `{name}` in {of}; the episodes are {', '.join(names)}")
    if not chosen:
        raise TrundleError(f"episodes: name at least one episode of {of}, or use None for all")
    return chosen


def short_names(names: Sequence[str]) -> dict[str, str]:
    """Return each name without the words that all share: "00" for "episode_00"."""
    first, last = min(names), max(names)
    same = next((k for k, pair in enumerate(zip(first, last, strict=False)) if pair[0] != pair[1]), 0)
    prefix = len(first[:same].rstrip("0123456789"))
    return {name: name[prefix:] for name in names}


def is_on_rail(recording: Recording) -> bool:
    """Return whether the object moves along one axis only."""
    return "theta" not in recording.metadata["object"].get("dof", ("x", "y", "theta"))


def open_loop(recording: Recording, model: Model) -> Series:
    """Simulate every episode in open loop.

    Parameters
    ----------
    recording : Recording
    model : Model
        Must contain a value for every parameter.

    Returns
    -------
    Series
        As in the report of a diagnosis; the simulated poses are `after`.

    Raises
    ------
    TrundleError
        If a parameter of the model has no value.
    """
    simulated, prepared = _predicted(recording, model), prepare(recording)
    described = recording.metadata["object"]
    episodes = [
        {
            "name": name,
            "held_out": prepared[name]["held_out"],
            "contact": prepared[name]["contact"],
            **simulated[name],
        }
        for name in prepared
        if name in simulated
    ]
    return Series.parse(
        {
            "footprint": outlines(described),
            "support": described.get("support"),
            "dof": described.get("dof"),
            "episodes": episodes,
        }
    )


def quasi_static_note(summary: Mapping[str, Any]) -> str:
    """Return a caution about the open loop of a fit to quasi-static pushes; empty for other fits."""
    if not summary.get("quasi_static"):
        return ""
    return (
        "The pushes are quasi-static: the fit compares wrenches, and small errors of the wrench grow in open "
        "loop. A diagnosis shows the wrench that the model requires."
    )


def _predicted(recording: Recording, model: Model) -> Mapping[str, Mapping[str, Any]]:
    """Return times `t`, and poses `observed` and `after` (n, 3) of each episode."""
    found = predict(recording, model)
    return {
        name: {"t": one.t, "observed": one.observed, "after": one.predicted} for name, one in found.items()
    }
