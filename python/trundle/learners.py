"""How an adaptive agent learns: physical laws fitted to what it has seen, or regressions in their place."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import Any, Literal, Protocol, TypeAlias

import numpy as np
import tomli_w

from trundle import _native
from trundle._native import Model, Recording, TrundleError, _Regression
from trundle.belief import Belief, Update
from trundle.diagnosis import Fit, Likelihood, fit, model_text
from trundle.online import Online

__all__ = ["KINDS", "Kind", "Learner", "learner"]

Kind: TypeAlias = Literal["filter", "shooting", "linear", "local"]
KINDS: tuple[Kind, ...] = ("filter", "shooting", "linear", "local")

DOUBT = 12.0
"""Nats by which a pose is predicted worse than noise alone explains, from which on something is missing."""
ENOUGH = 3.0
"""Seconds of pushing that a diagnosis needs at least."""
TOO_FAST = ["swinging_load"]
"""Effects that are not tried: the planner's steps of 50 ms do not follow a load that swings at some hertz."""
PATIENCE = 2.0
"""Times as much as at the last diagnosis must have been seen for the next one."""


Rows: TypeAlias = Sequence[Mapping[str, Any]]
"""A row for each parameter: name, mean, sd and unit."""
Richer: TypeAlias = tuple[Model, tuple[str, ...], tuple[str, ...]]
"""A model with more laws, those that the diagnoser named, and those that are only supposed."""


class Learner(Protocol):
    """Brings a belief up to date."""

    def learn(self, belief: Belief, period: float, rise: float) -> Update | None:
        """Return what was learnt, or None where too little has been seen to tell anything."""


def learner(kind: str, *, diagnose: bool, starts: int, seed: int) -> Learner:
    """Return the learner of a kind.

    Raises
    ------
    TrundleError
        If there is no such kind, or a regression is to be diagnosed.
    """
    if kind not in KINDS:
        raise TrundleError(f"learner = {kind!r}: choose {', '.join(KINDS)}")
    if kind in ("filter", "shooting"):
        return Physics("steps" if kind == "shooting" else None, diagnose=diagnose, starts=starts, seed=seed)
    if diagnose:
        raise TrundleError(f"learner = {kind!r}, diagnose = True: a regression has no laws to add to")
    return Regressor(local=kind == "local")


class Physics:
    """Fits a model's laws; asks the diagnoser which law is missing where they do not explain what is seen."""

    def __init__(self, likelihood: Likelihood | None, *, diagnose: bool, starts: int, seed: int) -> None:
        self._likelihood = likelihood
        self._diagnose = diagnose
        self._starts = starts
        self._seed = seed

    def learn(self, belief: Belief, period: float, rise: float) -> Update | None:
        """Fit, and where the prediction is off beyond the noise, diagnose."""
        time = period * (len(belief.seen) - 1)
        try:
            model, estimate = self._estimated(belief, period, rise)
        except TrundleError:
            # Too little has been moved yet to tell anything.
            return None
        named: tuple[str, ...] = ()
        supposed: tuple[str, ...] = ()
        if self._diagnose and time >= max(ENOUGH, PATIENCE * belief.consulted):
            richer = self._doubted(belief, belief.recording(period, rise), time)
            if richer is not None:
                model, named, supposed = richer
                belief.template, belief.online = model.freed(), None
                estimate = told(model)
        belief.models = (model,)
        return Update(time, model, estimate, named, supposed)

    def _estimated(self, belief: Belief, period: float, rise: float) -> tuple[Model, Rows]:
        """Return the model and its estimate: kept up to date, or fitted by the paper's likelihood."""
        if self._likelihood is not None:
            found = self._fitted(belief, belief.recording(period, rise))
            return found.model, found.summary["parameters"]
        if belief.online is None:
            belief.online = Online(belief.metadata, belief.template, starts=self._starts, seed=self._seed)
        belief.online.replace(belief.columns(period, rise))
        model = belief.online.model
        if model is None or belief.online.waiting is not None:
            raise TrundleError(belief.online.waiting or "nothing has been seen")
        return model, belief.online.estimate()

    def _doubted(self, belief: Belief, recording: Recording, time: float) -> Richer | None:
        """Diagnose where a fit predicts worse than the noise explains."""
        try:
            found = self._fitted(belief, recording)
        except TrundleError:
            return None
        return self._diagnosed(belief, recording, time, found) if doubtful(found) else None

    def _fitted(self, belief: Belief, recording: Recording) -> Fit:
        """Fit the paper's model from random starts, a richer one from where it was."""
        if belief.template is None:
            return fit(recording, likelihood=self._likelihood, starts=self._starts, seed=self._seed)
        free = {one["name"] for one in belief.template.parameters if one["value"] is None}
        start = {one["name"]: one["value"] for one in belief.model.parameters if one["name"] in free}
        try:
            return fit(recording, belief.template, likelihood=self._likelihood, start=start, starts=0)
        except TrundleError:
            # What has been seen since rules out where it was.
            return fit(
                recording, belief.template, likelihood=self._likelihood, starts=self._starts, seed=self._seed
            )

    def _diagnosed(self, belief: Belief, recording: Recording, time: float, found: Fit) -> Richer | None:
        """Return the model with what was missing: named, or supposed; None where nothing predicts better."""
        try:
            outcome = _native._diagnose(
                recording, model_text(None), seed=self._seed, without=TOO_FAST, progress=None
            )
        except TrundleError:
            # There is not enough motion yet.
            return None
        belief.consulted = time
        answer = outcome.answer
        if answer["verdict"] == "explained":
            return outcome.model, tuple(one["effect"] for one in answer["missing"]), ()
        return self._supposed(recording, answer["alternatives"], found)

    def _supposed(
        self, recording: Recording, alternatives: Sequence[Mapping[str, Any]], found: Fit
    ) -> Richer | None:
        """Return the best of what was tried, where it predicts better: to push, it need not explain all."""
        if not alternatives:
            return None
        effects = tuple(alternatives[0]["effect"].split(" + "))
        choices = product(*(laws_of(effect) for effect in effects))
        fits = [better for kinds in choices if (better := self._with(kinds, recording)) is not None]
        best = min(fits, key=shortfall, default=found)
        return (best.model, (), effects) if shortfall(best) < shortfall(found) - DOUBT else None

    def _with(self, kinds: Iterable[str], recording: Recording) -> Fit | None:
        """Fit the paper's model with more laws; None where that cannot be done."""
        laws = [{"kind": kind} for kind in ("viscous_wheel", *kinds)]
        template = Model.from_toml(tomli_w.dumps({"format": "trundle-model/1", "effect": laws}))
        try:
            return fit(recording, template, likelihood=self._likelihood, starts=self._starts, seed=self._seed)
        except TrundleError:
            return None


def laws_of(effect: str) -> list[str]:
    """Return the laws that go by an effect's name in a diagnosis: dry friction is of a point or of a face."""
    return [law["kind"] for law in _native.effects() if law["effect"] == effect]


def doubtful(found: Fit) -> bool:
    """Tell whether a fitted model predicts poses one second ahead worse than their noise explains."""
    return shortfall(found) > DOUBT


def shortfall(found: Fit) -> float:
    """Return by how much a fitted model predicts poses one second ahead worse than noise explains, nats."""
    density = found.summary["training"]["log_predictive_density"]
    if density is None:
        return 0.0
    noise = np.asarray(found.summary["noise"]["pose"])
    ideal = float(-np.log(noise).sum() - 1.5 * np.log(2 * np.pi * np.e))
    return ideal - float(density)


def told(model: Model) -> list[dict[str, Any]]:
    """Return the estimate that a model carries, as a fit tells it."""
    ranges = {name: (unit, mean, high - low) for name, unit, mean, (low, high) in _native._ranges(model)}
    return [
        {"name": name, "mean": mean, "sd": width / (2 * 1.959964), "unit": unit}
        for name, (unit, mean, width) in ranges.items()
    ]


class Regressor:
    """Learns next states from states and wrenches by regression, as in section V-B of the paper.

    Features are those of `trundle.baselines` that do not depend on where the object stands: stronger than the
    paper's.
    """

    LEAST = 8
    """Transitions without which there is nothing to learn."""
    MOST = 60
    """Transitions that a locally weighted regression keeps, the latest: a prediction weighs all of them."""

    def __init__(self, *, local: bool) -> None:
        self._local = local

    def learn(self, belief: Belief, period: float, rise: float) -> Update | None:
        """Fit to all transitions seen, or the latest."""
        data = belief.transitions(period, rise)
        if len(data[0]) < self.LEAST:
            return None
        if self._local:
            before, wrench, dt, after = (column[-self.MOST :] for column in data)
            belief.learnt = _Regression.local((before, wrench, dt, after), "body")
        else:
            belief.learnt = _Regression.linear(data, "body")
        return Update(period * (len(belief.seen) - 1), belief.model, [])
