"""Read the history of an episode: the motion, the belief after each fit, and the truth."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import trundle
from trundle.picture import outlines
from trundle.report import wording
from trundle.report.series import Array, finite

__all__ = [
    "Effect",
    "Episode",
    "Estimate",
    "Update",
    "Wheel",
    "named_effects",
    "parse_history",
    "parse_update",
    "select_stages",
    "supposed_effects",
    "wheels",
]

WHEEL = "viscous_wheel"


@dataclass(frozen=True)
class Wheel:
    """A wheel: position m, direction of least drag rad, least and greatest drag N s/m."""

    at: Array
    angle: float
    least: float
    most: float
    swapped: bool
    """Whether the least drag is the law's `mu_y`, across the law's rolling direction."""

    @classmethod
    def of(cls, effect: Mapping[str, Any]) -> Wheel:
        """Return the wheel of an effect, normalised so that the first drag is the least."""
        along, across, angle = (float(effect[name]) for name in ("mu_x", "mu_y", "angle"))
        swapped = across < along
        angle = angle + math.pi / 2 if swapped else angle
        least, most = min(along, across), max(along, across)
        return cls(np.array([effect["x"], effect["y"]], dtype=float), angle, least, most, swapped)


@dataclass(frozen=True)
class Effect:
    """Another effect: its name, and its position on the object, (2,) m, if it has one."""

    name: str
    at: Array | None

    @classmethod
    def of(cls, effect: Mapping[str, Any]) -> Effect:
        """Return an effect of a model's tables."""
        name, placed = effect_names()[effect["kind"]]
        at = np.array([effect["x"], effect["y"]], dtype=float) if placed else None
        return cls("a wheel" if effect["kind"] == WHEEL else wording.effect_name(name), at)


@dataclass(frozen=True)
class Estimate:
    """An estimated number with its standard deviation; None if it is not identifiable."""

    name: str
    mean: float | None
    sd: float | None
    unit: str


@dataclass(frozen=True)
class Update:
    """The belief from `time` s on.

    `wheel_covariance` is the covariance (2, 2) m² of the wheel's position, infinite along unknown axes; None
    if the agent's model has no uncertainty.
    """

    time: float
    wheel: Wheel | None
    wheel_covariance: Array | None
    estimates: tuple[Estimate, ...]
    other_effects: tuple[Effect, ...]
    named: tuple[str, ...]
    supposed: tuple[str, ...]
    regrasp: Array | None

    def value(self, name: str) -> Estimate | None:
        """Return an estimate by name; the wheel's drag by size: `least`, `most`, `angle`."""
        law = self._law(name)
        found = next((each for each in self.estimates if each.name == law), None)
        if found is None or name == law or found.mean is None or self.wheel is None:
            return found
        return Estimate(name, float(getattr(self.wheel, name)), found.sd, found.unit)

    def _law(self, name: str) -> str:
        """Return the law's parameter for a name by size."""
        if self.wheel is None or name not in ("least", "most", "angle"):
            return name
        own = {"least": "mu_x", "most": "mu_y", "angle": "angle"}
        if self.wheel.swapped:
            own = {"least": "mu_y", "most": "mu_x", "angle": "angle"}
        return f"{WHEEL}.{own[name]}"


@dataclass(frozen=True)
class Episode:
    """One episode: times (n,) s, the first 0; poses and goals (n, 3), wrenches (n, 3), grasps (n, 2).

    Wrench, distance (n,) m and heading error (n,) rad are those at the end of each action; the first are NaN.
    """

    seed: int
    t: Array
    pose: Array
    goal: Array
    wrench: Array
    grasp: Array
    distance: Array
    heading_error: Array
    updates: tuple[Update, ...]
    outline: tuple[Array, ...]
    support: Array
    obstacles: tuple[Array, ...]
    truth: Mapping[str, Any]
    outcome: Mapping[str, Any]

    @property
    def wheel(self) -> Wheel | None:
        """The true wheel of greatest drag; None without a wheel."""
        return max(wheels(self.truth), key=lambda wheel: wheel.least + wheel.most, default=None)

    @property
    def hidden(self) -> tuple[Effect, ...]:
        """The hidden effects other than wheels."""
        return tuple(Effect.of(each) for each in self.truth.get("effect", ()) if each["kind"] != WHEEL)

    @property
    def last(self) -> Update | None:
        """The last belief; None without a fit."""
        return self.updates[-1] if self.updates else None

    def true_value(self, held: str) -> float | None:
        """Return the true value for a name of `Update.value`; None if there is none."""
        if held in ("least", "most", "angle"):
            return None if self.wheel is None else float(getattr(self.wheel, held))
        kind, _, name = held.rpartition(".")
        if kind == "body":
            return finite(self.truth["body"].get(name))
        if kind == WHEEL and name in ("x", "y") and self.wheel is not None:
            return float(self.wheel.at["xy".index(name)])
        same = [effect for effect in self.truth.get("effect", ()) if effect["kind"] == kind]
        return finite(same[0].get(name)) if len(same) == 1 else None

    def off(self, update: Update) -> float | None:
        """Return the error of the estimated wheel's position, m."""
        if update.wheel is None or self.wheel is None:
            return None
        return float(np.hypot(*(update.wheel.at - self.wheel.at)))


def parse_history(history: Mapping[str, Any]) -> Episode:
    """Return a history as arrays."""
    steps: Sequence[Mapping[str, Any]] = history["steps"]
    rows = [history["first"], *steps]

    def column(name: str) -> Array:
        return np.array([[math.nan if v is None else v for v in row[name]] for row in rows], dtype=float)

    def after(name: str) -> Array:
        return np.array([math.nan, *(row[name] for row in steps)], dtype=float)

    thing = history["object"]
    obstacles = history["scene"].get("obstacle", ())
    return Episode(
        seed=history["seed"],
        t=np.array([0.0, *(row["t"] for row in steps)]),
        pose=column("pose"),
        goal=column("goal"),
        wrench=column("wrench"),
        grasp=column("grasp"),
        distance=after("distance"),
        heading_error=after("heading_error"),
        updates=tuple(parse_update(each) for each in history["updates"]),
        outline=tuple(outlines(thing)),
        support=np.array(thing.get("support") or np.empty((0, 2)), dtype=float).reshape(-1, 2),
        obstacles=tuple(np.array(each["polygon"], dtype=float) for each in obstacles),
        truth=history["truth"],
        outcome=history["outcome"],
    )


def wheels(model: Mapping[str, Any]) -> list[Wheel]:
    """Return the wheels of a model."""
    return [Wheel.of(effect) for effect in model.get("effect", ()) if effect["kind"] == WHEEL]


@cache
def effect_names() -> dict[str, tuple[str, bool]]:
    """Return for each kind of effect its name, and whether its x and y are a position on the object."""
    return {
        law["kind"]: (
            law["effect"],
            any(
                each["name"] == "x" and each["prior"]["distribution"] == "on_body"
                for each in law["parameters"]
            ),
        )
        for law in trundle.effects()
    }


def other_effects(model: Mapping[str, Any]) -> tuple[Effect, ...]:
    """Return the effects of a model except its first wheel."""
    effects: list[Mapping[str, Any]] = list(model.get("effect", ()))
    first = next((effect for effect in effects if effect["kind"] == WHEEL), None)
    return tuple(Effect.of(effect) for effect in effects if effect is not first)


def parse_update(row: Mapping[str, Any]) -> Update:
    """Return one row of a history's `updates`."""
    model = row["model"] or {}
    wheel = next(iter(wheels(model)), None)
    return Update(
        time=float(row["time"]),
        wheel=wheel,
        wheel_covariance=None if wheel is None else wheel_covariance(model.get("posterior")),
        estimates=tuple(
            Estimate(
                entry["name"], finite(entry.get("mean")), finite(entry.get("sd")), entry.get("unit") or ""
            )
            for entry in row["estimate"]
        ),
        other_effects=other_effects(model),
        named=tuple(row["named"]),
        supposed=tuple(row["supposed"]),
        regrasp=None if row["regrasp"] is None else np.array(row["regrasp"], dtype=float),
    )


def wheel_covariance(posterior: Mapping[str, Any] | None) -> Array | None:
    """Return the covariance (2, 2) m² of the wheel's position; infinite where the posterior has no value."""
    if not posterior:
        return None
    names: list[str] = posterior["names"]
    found = np.diag([math.inf, math.inf])
    axes = {
        axis: names.index(f"{WHEEL}.{name}") for axis, name in enumerate("xy") if f"{WHEEL}.{name}" in names
    }
    for axis, row in axes.items():
        for other, column in axes.items():
            found[axis, other] = posterior["covariance"][row][column]
    return found


def named_effects(episode: Episode) -> list[tuple[float, str]]:
    """Return the effects that the diagnoser named and added to the model, with times, s."""
    return [(each.time, name) for each in episode.updates for name in each.named]


def supposed_effects(episode: Episode) -> list[tuple[float, tuple[str, ...]]]:
    """Return the effects that the agent added without a diagnosis, with times, s."""
    return [(each.time, each.supposed) for each in episode.updates if each.supposed]


def select_stages(episode: Episode, most: int) -> list[Update]:
    """Return the updates that show how the belief developed.

    These are the first, the last, those that added laws, and others up to `most`, spread evenly in the
    logarithm of time.
    """
    found = episode.updates
    ends = {0, len(found) - 1} if found else set()
    kept = ends | {k for k, each in enumerate(found) if each.named or each.supposed}
    moment = np.log([each.time for each in found])
    for _ in range(min(most, len(found)) - len(kept)):
        gaps = np.abs(moment[:, None] - moment[sorted(kept)])
        kept.add(int(gaps.min(axis=1).argmax()))
    return [found[k] for k in sorted(kept)]
