"""Interface of the effects that the generators hide in recordings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import mujoco
import numpy as np

from trundle.experiments.blind.push import Kinematics, Wrench
from trundle.experiments.blind.readings import Readings
from trundle.experiments.blind.scene import ENGINES, Scene, Wheel, draw_point
from trundle.experiments.sampling import Floats, log_uniform

__all__ = [
    "ANGLE",
    "UNDER_OBJECT",
    "Context",
    "Draw",
    "Family",
    "HiddenEffect",
    "Hook",
    "Values",
    "by_name",
    "draws",
    "log",
    "uniform",
]

Values: TypeAlias = dict[str, Any]
Hook: TypeAlias = Callable[[mujoco.MjData], None]
Draw: TypeAlias = Callable[[np.random.Generator, Scene, Sequence[Floats]], Any]
"""Returns a random value. The last argument holds the poses (n, 3) of each episode without the effect."""


PLACES = {
    "point": ("x", "y"),
    "place": ("x", "y"),
    "anchor": ("anchor_x", "anchor_y"),
    "episode": ("episode",),
    "time": ("time",),
}
"""Values that are places or times of an effect, with their names in its law."""


@dataclass(frozen=True)
class Context:
    """The scene and the number of the episode; in MuJoCo also the world under construction and its object."""

    scene: Scene
    episode: int
    spec: Any = None
    table: Any = None


@dataclass(frozen=True)
class Family:
    """An effect that is hidden in recordings. Functions that are None change nothing.

    Attributes
    ----------
    name : str
        The catalogue's name of the effect, or a name of its own if it is out of catalogue.
    draw : callable
        Returns random values, or none if the scene has no place for the effect.
    scales : tuple of str
        Values proportional to the size of the effect; at zero there is no effect.
    out_of_catalogue : bool
        Whether the catalogue has no law for the effect. The correct answer is then "unexplained".
    resize, extend : callable, optional
        Return the values of the effect `size` times as strong; or with one more episode.
    build, hook : callable, optional
        Add the effect to a MuJoCo world; return a function to call before each step of MuJoCo.
    force : callable, optional
        Returns force and moment about the object's origin, world axes, which every engine applies.
    distort : callable, optional
        Returns distorted readings.
    parameters, where : callable, optional
        The truth in the terms of `diagnosis.json`. By default, values named in `PLACES` are its place, and
        the others its parameters.
    laws : callable, optional
        Returns the `[[effect]]` tables of the true model. By default one with places and parameters.
    fixed : dict
        Further values of that table.
    merge_wheel : callable, optional
        Returns the one wheel that is nearly equivalent to a wheel and this effect.
    engines : tuple of str
        Engines that simulate the effect.
    reads : bool
        Whether `draw` receives the wrenches (n, 3) instead of the poses.
    """

    name: str
    draw: Draw
    scales: tuple[str, ...] = ()
    out_of_catalogue: bool = False
    resize: Callable[[Values, float], Values] | None = None
    extend: Callable[[Values, np.random.Generator], Values] | None = None
    build: Callable[[Context, Values], None] | None = None
    hook: Callable[[Any, Context, Values], Hook | None] | None = None
    force: Callable[[Context, Values, float, Kinematics], Wrench] | None = None
    distort: Callable[[Readings, Context, Values], Readings] | None = None
    parameters: Callable[[Scene, Values], Values] | None = None
    where: Callable[[Scene, Values], Values | None] | None = None
    laws: Callable[[Scene, Values], list[Values]] | None = None
    fixed: Mapping[str, float] = field(default_factory=dict)
    merge_wheel: Callable[[Wheel, Values], Wheel] | None = None
    engines: tuple[str, ...] = ENGINES
    reads: bool = False


@dataclass(frozen=True)
class HiddenEffect:
    """A family with its values."""

    family: Family
    values: Values

    def scaled(self, size: float) -> HiddenEffect:
        """Return the effect `size` times as strong."""
        family, values = self.family, self.values
        if family.resize is not None:
            return HiddenEffect(family, family.resize(values, size))
        return HiddenEffect(family, {**values, **{name: size * values[name] for name in family.scales}})

    def extended(self, rng: np.random.Generator) -> HiddenEffect:
        """Return the effect with values for one more episode."""
        extend = self.family.extend
        return self if extend is None else HiddenEffect(self.family, extend(self.values, rng))

    def hook(self, model: Any, context: Context) -> Hook | None:
        """Return a function to call before every step of MuJoCo, or None."""
        family, values = self.family, self.values
        if family.hook is not None:
            return family.hook(model, context, values)
        force = family.force
        if force is None:
            return None

        def apply(data: mujoco.MjData) -> None:
            at = Kinematics.of([*data.qpos[:3].tolist(), *data.qvel[:3].tolist()])
            data.qfrc_applied[:3] += force(context, values, float(data.time), at)

        return apply

    def distort(self, seen: Readings, context: Context) -> Readings:
        """Return the readings as distorted by the effect."""
        return seen if self.family.distort is None else self.family.distort(seen, context, self.values)

    def parameters(self, scene: Scene) -> Values:
        """Return the true parameters in the terms of `diagnosis.json`."""
        if self.family.parameters is not None:
            return self.family.parameters(scene, self.values)
        known = {} if self.family.out_of_catalogue else self.values
        return {name: value for name, value in known.items() if name not in PLACES}

    def where(self, scene: Scene) -> Values | None:
        """Return the true place in the terms of `diagnosis.json`."""
        family, values = self.family, self.values
        if family.where is not None or family.out_of_catalogue:
            return None if family.where is None else family.where(scene, values)
        if "episode" in values:
            return {"event": {"episode": f"episode_{values['episode']:02}", "time": values["time"]}}
        places = {"point": "body_point", "anchor": "world_point", "place": "world_point"}
        return {key: values[name] for name, key in places.items() if values.get(name)} or None

    def truth(self, scene: Scene) -> Values:
        """Return `parameters` and `where` in the terms of `diagnosis.json`, as plain numbers."""
        return {"parameters": self.parameters(scene), "where": self.where(scene)}

    def laws(self, scene: Scene) -> list[Values]:
        """Return the `[[effect]]` tables of the true model; empty if the catalogue has no law."""
        family, values = self.family, self.values
        if family.laws is not None or family.out_of_catalogue:
            return [] if family.laws is None else family.laws(scene, values)
        law: Values = {"kind": family.name, **family.fixed, **self.parameters(scene)}
        for name in PLACES.keys() & values.keys():
            names = PLACES[name]
            law |= dict(zip(names, values[name] if len(names) > 1 else [values[name]], strict=True))
        return [law]


def log(low: float, high: float) -> Draw:
    """Draw a positive number that is uniform in its logarithm."""
    return lambda rng, scene, paths: log_uniform(rng, low, high)


def uniform(low: float, high: float) -> Draw:
    """Draw a number that is uniform between two limits."""
    return lambda rng, scene, paths: float(rng.uniform(low, high))


def draws(**named: Draw) -> Draw:
    """Draw values by name, in order."""
    return lambda rng, scene, paths: {name: draw(rng, scene, paths) for name, draw in named.items()}


ANGLE = uniform(-np.pi, np.pi)
UNDER_OBJECT: Draw = lambda rng, scene, paths: list(draw_point(rng, scene.shape))  # noqa: E731
"""Draws a point under the object."""


def by_name(*families: Family) -> Mapping[str, Family]:
    """Return families by name."""
    return {family.name: family for family in families}
