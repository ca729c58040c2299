"""Learners of an adaptive agent: fits of physical models, or regressions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, Literal, Protocol, TypeAlias

from trundle import _native
from trundle._native import Model, TrundleError, _BodyRegression, _Regression
from trundle.background import Background
from trundle.belief import Belief, PendingDiagnosis, Update
from trundle.fitting import Likelihood
from trundle.missing_effects import Extension, Suspicion, find_missing_effects, fit_present_model
from trundle.online import Online

__all__ = ["KINDS", "REGRESSIONS", "DiagnosisSettings", "Kind", "Learner", "make_learner"]

Kind: TypeAlias = Literal["body", "filter", "shooting", "linear", "local"]
KINDS: tuple[Kind, ...] = ("body", "filter", "shooting", "linear", "local")
REGRESSIONS: tuple[Kind, ...] = ("linear", "local")

TWIST_NOISE_SD = (0.005, 0.005, 0.01)
"""Noise of observed velocities (m/s) and spin (rad/s), standard deviations; see `trundle.envs.Push`."""
WRENCH_NOISE_SD = {"force": 0.4, "torque": 0.05}
"""The same of observed wrenches, N and N m, for environments that do not state it."""
MIN_DIAGNOSIS_TIME_S = 3.0
"""Minimum duration of the observations before a diagnosis, s."""
DIAGNOSIS_INTERVAL_FACTOR = 2.0
"""A diagnosis is repeated when the duration of the observations has grown by this factor."""
SDS_PER_95_INTERVAL = 2 * 1.959964
"""Width of a central 95 % interval of a normal distribution, standard deviations."""

Rows: TypeAlias = Sequence[Mapping[str, Any]]
"""A row for each parameter: name, mean, sd and unit."""


class Learner(Protocol):
    """Interface of a learner."""

    def begin(self, belief: Belief) -> None:
        """Prepare the belief of a new episode."""

    def is_due(self, belief: Belief, time: float) -> bool:
        """Return whether `learn` must be called at this time, s, even if no update is due."""

    def is_fast(self, belief: Belief) -> bool:
        """Return whether `learn` is fast enough for every action and has one most probable model."""

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


@dataclass(frozen=True)
class DiagnosisSettings:
    """When the result of a diagnosis is used; see `trundle.AgentSettings`.

    Attributes
    ----------
    delay : float
        Time after its start, s.
    realtime : bool
        Whether it is used as soon as it is ready, instead.
    """

    delay: float
    realtime: bool


def make_learner(kind: Kind, diagnosis: DiagnosisSettings | None, *, starts: int, seed: int) -> Learner:
    """Return a learner; arguments as in `trundle.AgentSettings`."""
    if kind in REGRESSIONS:
        return Regressor(local=kind == "local")
    if kind == "body":
        return BodyLearner(None, diagnosis, starts=starts, seed=seed)
    return Physics("steps" if kind == "shooting" else None, diagnosis, starts=starts, seed=seed)


class Physics:
    """Learner that fits a physical model, and diagnoses missing effects if it predicts badly.

    Parameters
    ----------
    likelihood : Likelihood or None
        None: the online estimate under the default likelihood.
    settings : DiagnosisSettings or None
        None: no diagnosis.
    starts, seed
        As for `make_learner`.
    """

    def __init__(
        self, likelihood: Likelihood | None, settings: DiagnosisSettings | None, *, starts: int, seed: int
    ) -> None:
        self._likelihood = likelihood
        self._diagnosis = settings
        self._starts = starts
        self._seed = seed

    def begin(self, belief: Belief) -> None:
        """Do nothing: the first model is that of the agent."""

    def is_due(self, belief: Belief, time: float) -> bool:
        """Return whether the result of a diagnosis is to be used now."""
        pending = belief.diagnosis
        if pending is None or self._diagnosis is None:
            return False
        return pending.work.is_finished if self._diagnosis.realtime else time >= pending.due

    def is_fast(self, belief: Belief) -> bool:
        """Return False: a search for several modes takes long."""
        return False

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
        extension = self._extension(belief, period, rise)
        if extension is not None and extension.model is not None:
            named, supposed = extension.named, extension.supposed
            belief.template, belief.online = extension.model.freed(), extension.online
            belief.online_since = 0.0 if extension.online is None else belief.diagnosed_at
            model, estimate = extension.model, estimate_rows(extension.model)
            if belief.online is not None:
                # There are later observations.
                with suppress(TrundleError):
                    model, estimate = self._estimate(belief, period, rise)
        belief.models = (model,)
        return Update(time, model, estimate, named, supposed)

    def _estimate(self, belief: Belief, period: float, rise: float) -> tuple[Model, Rows]:
        """Return the model and its estimate, from the online estimate or a fit with the given likelihood."""
        if self._likelihood is not None:
            found = fit_present_model(self._suspicion(belief, period, rise))
            return found.model, found.summary["parameters"]
        if belief.online is None:
            belief.online = Online(belief.metadata, belief.template, starts=self._starts, seed=self._seed)
        columns = belief.columns(period, rise)
        later = columns["t"] >= belief.online_since
        belief.online.replace({name: column[later] for name, column in columns.items()})
        model = belief.online.model
        if model is None or belief.online.waiting is not None:
            raise TrundleError(belief.online.waiting or "no estimate: there are no observations")
        return model, belief.online.estimate()

    def _suspicion(self, belief: Belief, period: float, rise: float) -> Suspicion:
        return Suspicion(
            recording=belief.recording(period, rise),
            template=belief.template,
            model=belief.model,
            likelihood=self._likelihood,
            starts=self._starts,
            seed=self._seed,
        )

    def _extension(self, belief: Belief, period: float, rise: float) -> Extension | None:
        """Return the result of a diagnosis that is to be used now; start one that is due."""
        settings, time = self._diagnosis, period * (len(belief.observations) - 1)
        if settings is None:
            return None
        extension: Extension | None = None
        if belief.diagnosis is None:
            if time < max(MIN_DIAGNOSIS_TIME_S, DIAGNOSIS_INTERVAL_FACTOR * belief.diagnosed_at):
                return None
            given = self._suspicion(belief, period, rise)
            if settings.delay == 0.0 and not settings.realtime:
                extension = find_missing_effects(given, lambda: None)
            else:
                belief.diagnosis = self._started(belief, given, time, period, rise)
                return None
        elif self.is_due(belief, time):
            pending, belief.diagnosis = belief.diagnosis, None
            time, extension = pending.started, pending.work.result()
        if extension is not None and extension.diagnosed:
            belief.diagnosed_at = time
        return extension

    def _started(
        self, belief: Belief, given: Suspicion, time: float, period: float, rise: float
    ) -> PendingDiagnosis:
        """Start a diagnosis on a thread of its own. It includes the first estimate with the richer model."""
        columns, metadata = belief.columns(period, rise), belief.metadata

        def work(check: Callable[[], None]) -> Extension:
            found = find_missing_effects(given, check)
            if found.model is None or self._likelihood is not None:
                return found
            check()
            online = Online(metadata, found.model.freed(), starts=self._starts, seed=self._seed)
            # A complete push: later updates of the richer model need no search, which would take long.
            online.update(columns)
            return replace(found, online=online)

        delay = 0.0 if self._diagnosis is None else self._diagnosis.delay
        return PendingDiagnosis(Background(work), time, time + delay - period / 2)


class BodyLearner(Physics):
    """Learner of a rigid body on viscous wheels, by linear regression of its equation of motion.

    Mass, mass centre, inertia and the damping of all wheels together have one posterior mode, so that no
    search is necessary. Dry friction of the whole object is added if the evidence for it is strong.
    Unlike the paper's model, several wheels may resist. Effects that a diagnosis names
    are estimated as by `Physics`.
    """

    def is_fast(self, belief: Belief) -> bool:
        """Return whether the model has no named effects."""
        return belief.template is None

    def _estimate(self, belief: Belief, period: float, rise: float) -> tuple[Model, Rows]:
        if belief.template is not None:
            return super()._estimate(belief, period, rise)
        if belief.body is None:
            noise = {**WRENCH_NOISE_SD, **belief.metadata.get("noise", {})}
            wrench = (noise["force"], noise["force"], noise["torque"])
            belief.body = _BodyRegression(belief.model, TWIST_NOISE_SD, wrench)
        belief.body.update(belief.transitions(period, rise))
        model = belief.body.model()
        known = {row["name"]: row for row in estimate_rows(model)}
        unknown = {"mean": None, "sd": None}
        rows = [{"name": one["name"], "unit": one["unit"], **unknown} for one in model.parameters]
        return model, [known.get(row["name"], row) for row in rows]


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

    def begin(self, belief: Belief) -> None:
        """Do nothing: the first model is that of the agent."""

    def is_due(self, belief: Belief, time: float) -> bool:
        """Return False: fits happen only at updates."""
        return False

    def is_fast(self, belief: Belief) -> bool:
        """Return False: a locally weighted regression takes long."""
        return False

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
