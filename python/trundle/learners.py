"""Learners of an adaptive agent: fits of physical models, or regressions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import Any, Literal, Protocol, TypeAlias

import numpy as np
import tomli_w

from trundle import _native
from trundle._native import Model, Recording, TrundleError, _Regression
from trundle.belief import Belief, Update
from trundle.fitting import Fit, Likelihood, fit
from trundle.online import Online

__all__ = ["KINDS", "REGRESSIONS", "Kind", "Learner", "make_learner"]

Kind: TypeAlias = Literal["filter", "shooting", "linear", "local"]
KINDS: tuple[Kind, ...] = ("filter", "shooting", "linear", "local")
REGRESSIONS: tuple[Kind, ...] = ("linear", "local")

MIN_LACK_OF_FIT_NATS = 12.0
"""Excess prediction error per pose, nats, above which an effect is considered missing."""
MIN_DIAGNOSIS_TIME_S = 3.0
"""Minimum duration of the observations before a diagnosis, s."""
DIAGNOSIS_INTERVAL_FACTOR = 2.0
"""A diagnosis is repeated when the duration of the observations has grown by this factor."""
EXCLUDED_EFFECTS = ["swinging_load"]
"""Effects that a diagnosis omits. The planner's steps of 50 ms do not resolve a swing of some hertz."""
SDS_PER_95_INTERVAL = 2 * 1.959964
"""Width of a central 95 % interval of a normal distribution, standard deviations."""

Rows: TypeAlias = Sequence[Mapping[str, Any]]
"""A row for each parameter: name, mean, sd and unit."""
ExtendedModel: TypeAlias = tuple[Model, tuple[str, ...], tuple[str, ...]]
"""A model with additional effects, those that the diagnosis named, and those that are only supposed."""


class Learner(Protocol):
    """Interface of a learner."""

    def learn(self, belief: Belief, period: float, rise: float) -> Update | None:
        """Fit to all observations of a belief.

        Parameters
        ----------
        belief : Belief
            Updated in place.
        period : float
            Time between two observations, s.
        rise : float
            Time in which the wrench changes from one action to the next, s.

        Returns
        -------
        Update or None
            None if the observations do not suffice.
        """


def make_learner(kind: Kind, *, diagnose: bool, starts: int, seed: int) -> Learner:
    """Return a learner; arguments as in `trundle.AgentSettings`."""
    if kind in REGRESSIONS:
        return Regressor(local=kind == "local")
    return Physics("steps" if kind == "shooting" else None, diagnose=diagnose, starts=starts, seed=seed)


class Physics:
    """Learner that fits a physical model, and diagnoses missing effects if it predicts badly.

    Parameters
    ----------
    likelihood : Likelihood or None
        None: the online estimate under the default likelihood.
    diagnose, starts, seed
        As for `make_learner`.
    """

    def __init__(self, likelihood: Likelihood | None, *, diagnose: bool, starts: int, seed: int) -> None:
        self._likelihood = likelihood
        self._diagnose = diagnose
        self._starts = starts
        self._seed = seed

    def learn(self, belief: Belief, period: float, rise: float) -> Update | None:
        """Fit the model; diagnose missing effects if one is due."""
        time = period * (len(belief.observations) - 1)
        try:
            model, estimate = self._estimate(belief, period, rise)
        except TrundleError:
            # The object has not moved enough yet.
            return None
        named: tuple[str, ...] = ()
        supposed: tuple[str, ...] = ()
        earliest = max(MIN_DIAGNOSIS_TIME_S, DIAGNOSIS_INTERVAL_FACTOR * belief.diagnosed_at)
        if self._diagnose and time >= earliest:
            extended = self._extend_if_misfit(belief, belief.recording(period, rise), time)
            if extended is not None:
                model, named, supposed = extended
                belief.template, belief.online = model.freed(), None
                estimate = estimate_rows(model)
        belief.models = (model,)
        return Update(time, model, estimate, named, supposed)

    def _estimate(self, belief: Belief, period: float, rise: float) -> tuple[Model, Rows]:
        """Return the model and its estimate, from the online estimate or a fit with the given likelihood."""
        if self._likelihood is not None:
            found = self._fit(belief, belief.recording(period, rise))
            return found.model, found.summary["parameters"]
        if belief.online is None:
            belief.online = Online(belief.metadata, belief.template, starts=self._starts, seed=self._seed)
        belief.online.replace(belief.columns(period, rise))
        model = belief.online.model
        if model is None or belief.online.waiting is not None:
            raise TrundleError(belief.online.waiting or "no estimate: there are no observations")
        return model, belief.online.estimate()

    def _extend_if_misfit(self, belief: Belief, recording: Recording, time: float) -> ExtendedModel | None:
        """Return a model with additional effects if a fit of the present one predicts badly; else None."""
        try:
            found = self._fit(belief, recording)
        except TrundleError:
            return None
        return self._diagnosed(belief, recording, time, found) if has_lack_of_fit(found) else None

    def _fit(self, belief: Belief, recording: Recording) -> Fit:
        """Fit the paper's model from random starts, an extended model from its present values."""
        if belief.template is None:
            return fit(recording, likelihood=self._likelihood, starts=self._starts, seed=self._seed)
        free = {one["name"] for one in belief.template.parameters if one["value"] is None}
        start = {one["name"]: one["value"] for one in belief.model.parameters if one["name"] in free}
        try:
            return fit(recording, belief.template, likelihood=self._likelihood, start=start, starts=0)
        except TrundleError:
            # The latest observations rule out the present values.
            return fit(
                recording, belief.template, likelihood=self._likelihood, starts=self._starts, seed=self._seed
            )

    def _diagnosed(
        self, belief: Belief, recording: Recording, time: float, found: Fit
    ) -> ExtendedModel | None:
        """Return the model with named or supposed effects; None if no candidate predicts better."""
        try:
            outcome = _native._diagnose(
                recording, None, seed=self._seed, without=EXCLUDED_EFFECTS, progress=None
            )
        except TrundleError:
            # The object has not moved enough yet.
            return None
        belief.diagnosed_at = time
        answer = outcome.answer
        if answer["verdict"] == "explained":
            return outcome.model, tuple(one["effect"] for one in answer["missing"]), ()
        return self._supposed(recording, answer["alternatives"], found)

    def _supposed(
        self, recording: Recording, alternatives: Sequence[Mapping[str, Any]], found: Fit
    ) -> ExtendedModel | None:
        """Return the best candidate if it predicts better by `MIN_LACK_OF_FIT_NATS`; else None."""
        if not alternatives:
            return None
        effects = tuple(alternatives[0]["effect"].split(" + "))
        choices = product(*(kinds_of_effect(effect) for effect in effects))
        fits = [better for kinds in choices if (better := self._fit_with(kinds, recording)) is not None]
        best = min(fits, key=lack_of_fit, default=found)
        is_better = lack_of_fit(best) < lack_of_fit(found) - MIN_LACK_OF_FIT_NATS
        return (best.model, (), effects) if is_better else None

    def _fit_with(self, kinds: Iterable[str], recording: Recording) -> Fit | None:
        """Fit the paper's model with additional laws; None if the fit fails."""
        laws = [{"kind": kind} for kind in ("viscous_wheel", *kinds)]
        template = Model.from_toml(tomli_w.dumps({"format": "trundle-model/1", "effect": laws}))
        try:
            return fit(recording, template, likelihood=self._likelihood, starts=self._starts, seed=self._seed)
        except TrundleError:
            return None


def kinds_of_effect(effect: str) -> list[str]:
    """Return the kinds of laws that a diagnosis reports as `effect`; friction has several."""
    return [law["kind"] for law in _native.effects() if law["effect"] == effect]


def has_lack_of_fit(found: Fit) -> bool:
    """Return whether the lack of fit exceeds `MIN_LACK_OF_FIT_NATS`."""
    return lack_of_fit(found) > MIN_LACK_OF_FIT_NATS


def lack_of_fit(found: Fit) -> float:
    """Return the excess error of poses predicted one second ahead over that of pure noise, nats per pose.

    It is the expected log density of poses with the fitted noise minus the log predictive density.
    """
    density = found.summary["training"]["log_predictive_density"]
    if density is None:
        return 0.0
    noise = np.asarray(found.summary["noise"]["pose"])
    ideal = float(-np.log(noise).sum() - 1.5 * np.log(2 * np.pi * np.e))
    return ideal - float(density)


def estimate_rows(model: Model) -> list[dict[str, Any]]:
    """Return the posterior of a model in the format of a fit's estimate."""
    ranges = {name: (unit, mean, high - low) for name, unit, mean, (low, high) in _native._ranges(model)}
    return [
        {"name": name, "mean": mean, "sd": width / SDS_PER_95_INTERVAL, "unit": unit}
        for name, (unit, mean, width) in ranges.items()
    ]


class Regressor:
    """Learner that predicts next states from states and wrenches by regression (section V-B of the paper).

    Features are in object axes and do not depend on the pose ("body" in `trundle.baselines`). They are a
    stronger baseline than those of the paper.

    Parameters
    ----------
    local : bool
        Whether the regression is locally weighted.
    """

    MIN_TRANSITIONS = 8
    """Minimum number of transitions for a fit."""
    MAX_LOCAL_TRANSITIONS = 60
    """Maximum number of transitions of a locally weighted regression; a prediction weights all of them."""

    def __init__(self, *, local: bool) -> None:
        self._local = local

    def learn(self, belief: Belief, period: float, rise: float) -> Update | None:
        """Fit to all transitions, or to the latest ones."""
        data = belief.transitions(period, rise)
        if len(data[0]) < self.MIN_TRANSITIONS:
            return None
        if self._local:
            before, wrench, dt, after = (column[-self.MAX_LOCAL_TRANSITIONS :] for column in data)
            belief.regression = _Regression.local((before, wrench, dt, after), "body")
        else:
            belief.regression = _Regression.linear(data, "body")
        return Update(period * (len(belief.observations) - 1), belief.model, [])
