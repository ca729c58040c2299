"""Interface of the effects that the generators hide in recordings."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

import mujoco
import numpy as np

from trundle.experiments.blind.scene import Scene
from trundle.experiments.sampling import Floats

__all__ = ["EpisodeContext", "Family", "HiddenEffect", "Hook", "Values"]

Values: TypeAlias = dict[str, Any]
Hook: TypeAlias = Callable[[mujoco.MjData], None]


@dataclass(frozen=True)
class EpisodeContext:
    """The world under construction, its object, and the scene and number of the episode."""

    spec: Any
    table: Any
    scene: Scene
    episode: int


class Family(ABC):
    """An effect that is hidden in recordings. Subclasses override what their effect changes.

    Attributes
    ----------
    name : str
        The catalogue's name of the effect, or a name of its own if it is out of catalogue.
    out_of_catalogue : bool
        Whether the catalogue has no law for the effect.
    scales : tuple of str
        Values proportional to the size of the effect; at zero there is no effect.
    """

    name: ClassVar[str]
    out_of_catalogue: ClassVar[bool] = False
    scales: ClassVar[tuple[str, ...]] = ()

    @abstractmethod
    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return random values. `paths` are the poses (n, 3) of each episode without the effect."""

    def scaled(self, values: Values, size: float) -> Values:
        """Return the values of the effect `size` times as strong."""
        return {**values, **{name: size * values[name] for name in self.scales}}

    def extended(self, values: Values, rng: np.random.Generator) -> Values:
        """Return the values extended by one episode, if they differ between episodes."""
        return values

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:  # noqa: B027, optional
        """Add the effect's bodies, joints, springs and actuators to the MuJoCo world."""

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:  # noqa: B027, optional
        """Return a function to call before every step, or None."""

    def distort(self, seen: Any, context: EpisodeContext, values: Values) -> Any:
        """Return the readings as distorted by the effect."""
        return seen

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return `parameters` and `where` in the terms of `diagnosis.json`, as plain numbers.

        By default the values are the parameters, and the effect has no place. A family outside the catalogue
        has no parameters.
        """
        return {"parameters": {} if self.out_of_catalogue else dict(values), "where": None}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the `[[effect]]` tables of the true model; empty if the catalogue has no law for the effect.

        By default one table with the parameters of `truth`.
        """
        if self.out_of_catalogue:
            return []
        return [{"kind": self.name, **self.truth(scene, values)["parameters"]}]


@dataclass(frozen=True)
class HiddenEffect:
    """A family with its values."""

    family: Family
    values: Values

    def scaled(self, size: float) -> HiddenEffect:
        """Return the effect `size` times as strong."""
        return HiddenEffect(self.family, self.family.scaled(self.values, size))
