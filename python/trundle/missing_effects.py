"""Search for effects that the model of an adaptive agent misses."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import tomli_w

from trundle import _native
from trundle._native import Model, Recording, TrundleError
from trundle.fitting import Fit, Likelihood, fit
from trundle.online import Online

__all__ = ["Extension", "Suspicion", "find_missing_effects"]

MIN_LACK_OF_FIT_NATS = 12.0
"""Excess prediction error per pose, nats, above which an effect is considered missing."""
EXCLUDED_EFFECTS = ["swinging_load"]
"""Effects that a diagnosis omits. The planner's steps of 50 ms do not resolve a swing of some hertz."""


@dataclass(frozen=True)
class Suspicion:
    """What the search for missing effects uses.

    Attributes
    ----------
    recording : Recording
        The observations.
    template : Model or None
        Model with free parameters that is fitted; None: the paper's model.
    model : Model
        The same model with its present values.
    likelihood, starts, seed
        Arguments of `trundle.fit`.
    """

    recording: Recording
    template: Model | None
    model: Model
    likelihood: Likelihood | None
    starts: int
    seed: int


@dataclass(frozen=True)
class Extension:
    """Result of a search.

    Attributes
    ----------
    diagnosed : bool
        Whether there was a diagnosis: the present model predicts badly, and the object has moved enough.
    model : Model or None
        Model with additional effects; None if no candidate predicts better.
    named, supposed : tuple of str
        Additional effects that the diagnosis named, and those that are only supposed.
    online : Online or None
        Online estimate of the parameters of `model` from the observations as a complete push; None: not
        started yet.
    """

    diagnosed: bool
    model: Model | None = None
    named: tuple[str, ...] = ()
    supposed: tuple[str, ...] = ()
    online: Online | None = None


def find_missing_effects(given: Suspicion, check: Callable[[], None]) -> Extension:
    """Diagnose the observations if a fit of the present model predicts badly.

    Parameters
    ----------
    given : Suspicion
    check : callable
        Called now and then; an exception that it raises stops the work.
    """
    try:
        found = fit_present_model(given)
        check()
        if not has_lack_of_fit(found):
            return Extension(diagnosed=False)
        outcome = _native._diagnose(
            given.recording,
            None,
            seed=given.seed,
            without=EXCLUDED_EFFECTS,
            progress=lambda _stage, _share: check(),
        )
    except TrundleError:
        # The object has not moved enough yet.
        return Extension(diagnosed=False)
    answer = outcome.answer
    if answer["verdict"] == "explained":
        named = tuple(one["effect"] for one in answer["missing"])
        return Extension(diagnosed=True, model=outcome.model, named=named)
    return supposed_extension(given, answer["alternatives"], found, check)


def fit_present_model(given: Suspicion) -> Fit:
    """Fit the paper's model from random starts, an extended model from its present values."""
    searched: dict[str, Any] = {"likelihood": given.likelihood, "starts": given.starts, "seed": given.seed}
    if given.template is None:
        return fit(given.recording, **searched)
    free = {one["name"] for one in given.template.parameters if one["value"] is None}
    start = {one["name"]: one["value"] for one in given.model.parameters if one["name"] in free}
    try:
        return fit(given.recording, given.template, likelihood=given.likelihood, start=start, starts=0)
    except TrundleError:
        # The latest observations rule out the present values.
        return fit(given.recording, given.template, **searched)


def supposed_extension(
    given: Suspicion, alternatives: Sequence[Mapping[str, Any]], found: Fit, check: Callable[[], None]
) -> Extension:
    """Return the best candidate if it predicts better by `MIN_LACK_OF_FIT_NATS`."""
    if not alternatives:
        return Extension(diagnosed=True)
    effects = tuple(alternatives[0]["effect"].split(" + "))
    fits = list[Fit]()
    for kinds in product(*(kinds_of_effect(effect) for effect in effects)):
        check()
        fits += fits_with(kinds, given)
    best = min(fits, key=lack_of_fit, default=found)
    if lack_of_fit(best) < lack_of_fit(found) - MIN_LACK_OF_FIT_NATS:
        return Extension(diagnosed=True, model=best.model, supposed=effects)
    return Extension(diagnosed=True)


def fits_with(kinds: Iterable[str], given: Suspicion) -> list[Fit]:
    """Return the fit of the paper's model with additional laws; an empty list if the fit fails."""
    laws = [{"kind": kind} for kind in ("viscous_wheel", *kinds)]
    template = Model.from_toml(tomli_w.dumps({"format": "trundle-model/1", "effect": laws}))
    try:
        found = fit(
            given.recording, template, likelihood=given.likelihood, starts=given.starts, seed=given.seed
        )
    except TrundleError:
        return []
    return [found]


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
