"""What a hidden effect is to the generator of recordings."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

import mujoco
import numpy as np
from numpy.typing import NDArray

from trundle.experiments.blind.scene import Scene

__all__ = ["EpisodeContext", "Family", "HiddenEffect", "Hook", "Values"]

Floats: TypeAlias = NDArray[np.float64]
Values: TypeAlias = dict[str, Any]
Hook: TypeAlias = Callable[[mujoco.MjData], None]


@dataclass(frozen=True)
class EpisodeContext:
    """Where and when something is furnished: a world under construction, of one episode."""

    spec: Any
    table: Any
    scene: Scene
    episode: int


class Family(ABC):
    """An effect that is hidden in recordings. A subclass overrides what its effect does.

    Attributes
    ----------
    name : str
        The catalogue's name of the effect, or the family's if it is foreign.
    foreign : bool
        Whether the catalogue has no such effect.
    scales : tuple of str
        Values that are proportional to the effect's size; at zero there is no effect.
    """

    name: ClassVar[str]
    out_of_catalogue: ClassVar[bool] = False
    scales: ClassVar[tuple[str, ...]] = ()

    @abstractmethod
    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return its sizes and places. `paths` are the poses (n, 3) of each episode without it."""

    def scaled(self, values: Values, size: float) -> Values:
        """Return it `size` times as strong."""
        return {**values, **{name: size * values[name] for name in self.scales}}

    def extended(self, values: Values, rng: np.random.Generator) -> Values:
        """Return it with values for one more episode, where each has its own."""
        return values

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:  # noqa: B027, many put nothing there
        """Add its bodies, joints, springs and actuators to the world."""

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:  # noqa: B027, most need none
        """Return what is done before every step, if anything."""

    def distort(self, seen: Any, context: EpisodeContext, values: Values) -> Any:
        """Return what the instruments make of the motion (`instruments.Seen`)."""
        return seen

    @abstractmethod
    def truth(self, scene: Scene, values: Values) -> Values:
        """Return `parameters` and `where` in the terms of `diagnosis.json`, plain numbers."""

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the `[[effect]]` tables that the oracle adds, with true values; none: no law for it."""
        return []


@dataclass(frozen=True)
class HiddenEffect:
    """A family with its sizes."""

    family: Family
    values: Values

    def scaled(self, size: float) -> HiddenEffect:
        """Return it `size` times as strong."""
        return HiddenEffect(self.family, self.family.scaled(self.values, size))
