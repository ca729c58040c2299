"""Interface of the effects that are hidden in recordings of mechanisms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, TypeAlias

import numpy as np

from trundle.experiments.blind.mechanism.scene import SOURCES, Scene
from trundle.experiments.sampling import Floats

__all__ = ["Family", "HiddenEffect", "State", "Statistics", "Values"]

Values: TypeAlias = dict[str, Any]
State: TypeAlias = SimpleNamespace
"""`t`, `memory`, and by joint, (n,): `q`, `v`, `a` of the last step, acting effort `u` and `external()`."""


@dataclass(frozen=True)
class Statistics:
    """Rms and largest efforts (n,), rms speeds (n,) and positions (T, n) of the motion without effects."""

    effort: Floats
    largest: Floats
    speed: Floats
    positions: Floats

    def position(self, joint: int, quantile: float) -> float:
        """Return a quantile of the positions of a joint."""
        return float(np.quantile(self.positions[:, joint], quantile))

    def span(self, joint: int) -> float:
        """Return the range of the positions of a joint."""
        return float(np.ptp(self.positions[:, joint]))


Draw: TypeAlias = Callable[[np.random.Generator, Scene, Statistics, int], Values | None]


@dataclass(frozen=True)
class Family:
    """An effect that is hidden in recordings. Functions that are None change nothing.

    Attributes
    ----------
    name : str
    draw : callable
        Returns random values for a joint, or None if the scene has no place for it.
    out_of_catalogue : bool
    sources : tuple of str
        Sources of effort with which it can be hidden.
    fixed : str, optional
        A kind of nominal parameter that must not be free.
    model : callable, optional
        Changes a MuJoCo specification: (specification, joint's name, values). Both engines use it.
    native : callable, optional
        The same, for MuJoCo's engine only, in place of `force`.
    force : callable, optional
        Adds efforts on the joints' side to an array (n,): (values, state, array).
    level : callable, optional
        Returns the level of dry friction on the drive's side of its joint: (values, state).
    transmission : callable, optional
        Returns the effort of the joint between drive and link for its relative position and velocity, for the
        engine other than MuJoCo; `native` builds it in MuJoCo.
    drive : callable, optional
        Returns a function that turns the command (n,) at each time step into the acting one.
    distort : callable, optional
        Changes readings at every time step: (values, readings with `t` (T,), `q` and `effort` (T, n)).
    body, without_place : bool
        Whether its place is a body; whether it has none.
    """

    name: str
    draw: Draw
    out_of_catalogue: bool = False
    sources: tuple[str, ...] = SOURCES
    fixed: str | None = None
    model: Callable[[Any, str, Values], None] | None = None
    native: Callable[[Any, str, Values], None] | None = None
    force: Callable[[Values, State, Floats], None] | None = None
    level: Callable[[Values, State], float] | None = None
    transmission: Callable[[Values, float, float], float] | None = None
    drive: Callable[[Values], Callable[[Floats], Floats]] | None = None
    distort: Callable[[Values, Any], None] | None = None
    body: bool = False
    without_place: bool = False


@dataclass(frozen=True)
class HiddenEffect:
    """A family with its values, among them `joint`, the number of its joint."""

    family: Family
    values: Values

    def truth(self, scene: Scene) -> Values:
        """Return the effect's name, parameters and place, in the terms of `diagnosis.json`."""
        joint = scene.robot.joints[self.values["joint"]]
        where: Values | None = {"joint": joint}
        if self.family.body:
            where = {"body": self.values["body"]}
        if self.family.without_place:
            where = None
        known = {name: value for name, value in self.values.items() if name not in ("joint", "body")}
        return {"effect": self.family.name, "parameters": known, "where": where}
