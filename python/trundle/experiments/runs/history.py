"""The history of an episode as arrays: the motion, the belief after each fit, and the true model."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import trundle
from trundle.picture import outlines
from trundle.report import wording
from trundle.report.series import Array, finite

__all__ = ["Effect", "Episode", "Update", "Wheel", "parse_history", "parse_update", "select_stages"]

WHEEL = "viscous_wheel"


@dataclass(frozen=True)
class Wheel:
    """A wheel: position m, direction of least drag rad, least and greatest drag N s/m.

    `parameters` maps these names to the law's parameters, because the least drag may be along either axis.
    """

    at: Array
    angle: float
    least: float
    most: float
    parameters: Mapping[str, str]

    @classmethod
    def of(cls, effect: Mapping[str, Any]) -> Wheel:
        """Return the wheel of an effect."""
        least, most = sorted(("mu_x", "mu_y"), key=lambda name: float(effect[name]))
        angle = float(effect["angle"]) + (math.pi / 2 if least == "mu_y" else 0.0)
        at = np.array([effect["x"], effect["y"]], dtype=float)
        parameters = {"least": least, "most": most, "angle": "angle"}
        return cls(at, angle, float(effect[least]), float(effect[most]), parameters)


@dataclass(frozen=True)
class Effect:
    """Another effect: its name, and its position on the object, (2,) m, if it has one."""

    name: str
    at: Array | None

    @classmethod
    def of(cls, effect: Mapping[str, Any]) -> Effect:
        """Return an effect of a model's tables."""
        law = laws()[effect["kind"]]
        placed = any(
            each["name"] == "x" and each["prior"]["distribution"] == "on_body" for each in law["parameters"]
        )
        at = np.array([effect["x"], effect["y"]], dtype=float) if placed else None
        return cls("a wheel" if effect["kind"] == WHEEL else wording.effect_name(law["effect"]), at)


@cache
def laws() -> dict[str, Any]:
    """Return the catalogue by kind."""
    return {law["kind"]: law for law in trundle.effects()}


@dataclass(frozen=True)
class Update:
    """The belief from `time` s on.

    Attributes
    ----------
    wheel_covariance
        Covariance (2, 2) m² of the wheel's position, infinite along unknown axes; None if the agent's model
        has no uncertainty.
    estimates
        Mean, sd and unit by parameter, and for the wheel also by the names `least`, `most` and `angle`. Mean
        and sd are None if the parameter is not identifiable.
    named, supposed
        Effects that a diagnosis added to the model, and those that the agent added without one.
    """

    time: float
    wheel: Wheel | None
    wheel_covariance: Array | None
    estimates: Mapping[str, Mapping[str, Any]]
    other_effects: tuple[Effect, ...]
    named: tuple[str, ...]
    supposed: tuple[str, ...]
    regrasp: Array | None

    @property
    def wheel_sd(self) -> Array | None:
        """The standard deviation (2,) of the wheel's position, m."""
        return None if self.wheel_covariance is None else np.sqrt(np.diag(self.wheel_covariance))

    @property
    def has_located_wheel(self) -> bool:
        """Whether a coordinate of the wheel's position is identifiable."""
        return self.wheel_sd is None or bool(np.isfinite(self.wheel_sd).any())


@dataclass(frozen=True)
class Episode:
    """One episode: times (n,) s, the first 0; poses and wrenches (n, 3), grasps (n, 2); the goal (3,).

    Wrench, distance (n,) m and heading error (n,) rad are those at the end of each action; the first are NaN.
    `wheel` is the true wheel of greatest drag, and `hidden` are the hidden effects other than wheels.
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
    wheel: Wheel | None
    hidden: tuple[Effect, ...]
    outcome: Mapping[str, Any]

    def true_value(self, name: str) -> float | None:
        """Return the true value of an estimate; None if there is none."""
        if name in ("least", "most", "angle"):
            return None if self.wheel is None else float(getattr(self.wheel, name))
        kind, _, parameter = name.rpartition(".")
        if kind == "body":
            return finite(self.truth["body"].get(parameter))
        if kind == WHEEL and parameter in ("x", "y") and self.wheel is not None:
            return float(self.wheel.at["xy".index(parameter)])
        same = [effect for effect in self.truth.get("effect", ()) if effect["kind"] == kind]
        return finite(same[0].get(parameter)) if len(same) == 1 else None

    def wheel_error(self, update: Update) -> float | None:
        """Return the error of the estimated wheel's position, m."""
        if update.wheel is None or self.wheel is None:
            return None
        return float(np.hypot(*(update.wheel.at - self.wheel.at)))


def parse_history(history: Mapping[str, Any]) -> Episode:
    """Return a history as arrays."""
    rows = [{"t": 0.0, **history["first"]}, *history["steps"]]
    names = ("t", "pose", "wrench", "grasp", "distance", "heading_error")
    described, truth = history["object"], history["truth"]
    wheels = [Wheel.of(effect) for effect in truth.get("effect", ()) if effect["kind"] == WHEEL]
    return Episode(
        seed=history["seed"],
        **{name: np.array([row.get(name) for row in rows], dtype=float) for name in names},
        goal=np.array(rows[-1]["goal"], dtype=float),
        updates=tuple(parse_update(each) for each in history["updates"]),
        outline=tuple(outlines(described)),
        support=np.array(described.get("support") or (), dtype=float).reshape(-1, 2),
        obstacles=tuple(np.array(each["polygon"], float) for each in history["scene"].get("obstacle", ())),
        truth=truth,
        wheel=max(wheels, key=lambda wheel: wheel.least + wheel.most, default=None),
        hidden=tuple(Effect.of(each) for each in truth.get("effect", ()) if each["kind"] != WHEEL),
        outcome=history["outcome"],
    )


def parse_update(row: Mapping[str, Any]) -> Update:
    """Return one row of a history's `updates`."""
    model = row["model"] or {}
    effects: list[Mapping[str, Any]] = list(model.get("effect", ()))
    first = next((effect for effect in effects if effect["kind"] == WHEEL), None)
    wheel = None if first is None else Wheel.of(first)
    estimates = {
        each["name"]: {"mean": each.get("mean"), "sd": each.get("sd"), "unit": each.get("unit") or ""}
        for each in row["estimate"]
    }
    for name, parameter in () if wheel is None else wheel.parameters.items():
        if (found := estimates.get(f"{WHEEL}.{parameter}")) is not None:
            known = found["mean"] is not None
            estimates[name] = {**found, "mean": getattr(wheel, name) if known else None}
    return Update(
        time=float(row["time"]),
        wheel=wheel,
        wheel_covariance=None if wheel is None else wheel_covariance(model.get("posterior")),
        estimates=estimates,
        other_effects=tuple(Effect.of(effect) for effect in effects if effect is not first),
        named=tuple(row["named"]),
        supposed=tuple(row["supposed"]),
        regrasp=None if row["regrasp"] is None else np.array(row["regrasp"], dtype=float),
    )


def wheel_covariance(posterior: Mapping[str, Any] | None) -> Array | None:
    """Return the covariance (2, 2) m² of the wheel's position; infinite where the posterior has no value."""
    if not posterior:
        return None
    names = posterior["names"]
    known = [axis for axis in (0, 1) if f"{WHEEL}.{'xy'[axis]}" in names]
    rows = [names.index(f"{WHEEL}.{'xy'[axis]}") for axis in known]
    found = np.diag([math.inf, math.inf])
    found[np.ix_(known, known)] = np.array(posterior["covariance"])[np.ix_(rows, rows)]
    return found


def select_stages(episode: Episode, most: int) -> list[Update]:
    """Return the updates that show how the belief developed.

    These are the first, the last, those that added laws, and others up to `most`, spread evenly in the
    logarithm of time.
    """
    found = episode.updates
    kept = {0, len(found) - 1} if found else set()
    kept |= {k for k, each in enumerate(found) if each.named or each.supposed}
    moment = np.log([each.time for each in found])
    for _ in range(min(most, len(found)) - len(kept)):
        gaps = np.abs(moment[:, None] - moment[sorted(kept)])
        kept.add(int(gaps.min(axis=1).argmax()))
    return [found[k] for k in sorted(kept)]
