"""Section V-B of the paper: models learnt from transitions, and the one score they are compared by.

A transition is a state, the wrench held from it on, and the state that followed. States are rows
``[x, y, theta, v_x, v_y, omega]`` of the object frame in the world, ``[m, m, rad, m/s, m/s, rad/s]``;
wrenches are rows ``[f_x, f_y, torque]``, ``[N, N, N m]``, in object axes about the object's origin: they turn
with the object.

Examples
--------
>>> import trundle
>>> from trundle import baselines
>>> chair = trundle.objects.read("configs/objects/chair.toml").models["free"]
>>> training = baselines.Transitions.simulated(chair, 50, seed=0)
>>> test = baselines.Transitions.simulated(chair, 200, seed=1)
>>> baselines.LinearRegression().fit(training).score(test) > 0.995
True
"""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trundle import _native
from trundle._native import Model, Recording, TrundleError

__all__ = [
    "LinearRegression",
    "LocallyWeightedRegression",
    "PhysicalModel",
    "Transitions",
    "noise_sd",
    "r2",
]

Floats: TypeAlias = NDArray[np.float64]
Features: TypeAlias = Literal["world", "recorded", "body"]


def _rows(name: str, values: ArrayLike, width: int) -> Floats:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != width:
        raise TrundleError(f"{name}: has the shape {array.shape}; give (n, {width})")
    return array


def _inputs(before: ArrayLike, wrench: ArrayLike, dt: ArrayLike) -> tuple[Floats, Floats, Floats]:
    states, wrenches = _rows("before", before, 6), _rows("wrench", wrench, 3)
    if len(wrenches) != len(states):
        raise TrundleError(
            f"before has {len(states)} rows and wrench {len(wrenches)}: one for each transition"
        )
    times = np.asarray(dt, dtype=np.float64)
    if times.shape not in [(), (len(states),)]:
        raise TrundleError(f"dt: has the shape {times.shape}; give one number, or ({len(states)},)")
    return states, wrenches, np.broadcast_to(times, (len(states),)).copy()


@dataclass(frozen=True, eq=False)
class Transitions:
    """Observations (eq. 7).

    Attributes
    ----------
    before : ndarray, shape (n, 6)
        States.
    wrench : ndarray, shape (n, 3)
        Wrenches held from then on.
    dt : ndarray, shape (n,)
        For how long, s; one number stands for all.
    after : ndarray, shape (n, 6)
        The states that followed.
    """

    before: Floats
    wrench: Floats
    dt: Floats
    after: Floats

    def __post_init__(self) -> None:
        before, wrench, dt = _inputs(self.before, self.wrench, self.dt)
        after = _rows("after", self.after, 6)
        if len(after) != len(before):
            raise TrundleError(
                f"before has {len(before)} rows and after {len(after)}: one for each transition"
            )
        for name, value in [("before", before), ("wrench", wrench), ("dt", dt), ("after", after)]:
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.before)

    def __getitem__(self, rows: slice | Floats | NDArray[np.bool_] | NDArray[np.int64]) -> Transitions:
        """Return some of them."""
        return Transitions(self.before[rows], self.wrench[rows], self.dt[rows], self.after[rows])

    @property
    def _columns(self) -> tuple[Floats, Floats, Floats, Floats]:
        return self.before, self.wrench, self.dt, self.after

    @classmethod
    def simulated(
        cls,
        model: Model,
        n: int,
        *,
        seed: int = 0,
        dt: float = 0.2,
        per_episode: int = 10,
        speed: float = 0.3,
        spin: float = 0.4,
        force: float = 150.0,
        arena: float = 0.5,
        heading: float = 0.5,
    ) -> Transitions:
        """Push a model, free of contact and of noise.

        Each push aims at a random twist, as a velocity-controlled gripper does: its wrench would bring the
        object there in `dt`, and keep it there against its friction. Training and test data come of this same
        procedure.

        Parameters
        ----------
        model : Model
            With all values given.
        n : int
            How many transitions; more of them begin with the same.
        seed : int
            Of everything random.
        dt : float
            How long each wrench is held, s.
        per_episode : int
            Pushes from one random start at rest.
        speed, spin : float
            Standard deviation of the twist aimed at: along each axis in m/s, and in rad/s.
        force : float
            Largest force, N.
        arena, heading : float
            Episodes begin within so many m, and rad, of the origin.

        Returns
        -------
        Transitions

        Raises
        ------
        TrundleError
            If a value of the model is free, or a setting makes no sense.
        """
        settings = {"dt": dt, "per_episode": per_episode, "speed": speed, "spin": spin}
        settings |= {"force": force, "arena": arena, "heading": heading}
        return cls(*_native._transitions(model, n, seed, settings))

    @classmethod
    def recorded(
        cls, recording: Recording | str | os.PathLike[str], *, dt: float = 0.2, held_out: bool = False
    ) -> Transitions:
        """Cut a recording into transitions, so that regressions learn from what a fit learns from.

        Parameters
        ----------
        recording : Recording or path-like
            The recording, or its folder.
        dt : float
            Length of an interval, s. Those in a gap of poses or of wrenches are left out.
        held_out : bool
            The held-out episodes instead of those to fit.

        Returns
        -------
        Transitions
            States by the smoother over all poses of an episode; the wrench is the mean, tared, over the
            interval.

        Raises
        ------
        TrundleError
            If the recording cannot be prepared.
        """
        return cls(*_native._cut(recording, dt, held_out))

    def with_noise(self, sd: ArrayLike, *, seed: int = 0) -> Transitions:
        """Add normal noise to the states after; the states before and the wrenches stay exact.

        Parameters
        ----------
        sd : array_like, shape (6,) or ()
            Standard deviation of each channel, SI units, as from `noise_sd`.
        seed : int
            Of the noise.

        Returns
        -------
        Transitions
        """
        deviations = np.broadcast_to(np.asarray(sd, dtype=np.float64), (6,)).tolist()
        return replace(self, after=_native._noisy(self._columns, deviations, seed))


def noise_sd(sigma: float, reading: Literal["si", "cm_deg", "of_motion"], data: Transitions) -> Floats:
    """Return what a σ without units, as the paper's, may mean in each channel.

    Parameters
    ----------
    sigma : float
        The number.
    reading : {"si", "cm_deg", "of_motion"}
        In m, rad, m/s and rad/s; in cm, degrees, cm/s and degrees/s; or as a multiple of the standard
        deviation of each channel's change over `data`.
    data : Transitions
        Noise-free.

    Returns
    -------
    ndarray, shape (6,)
        Standard deviations, SI units.
    """
    return np.array(_native._noise_sd(sigma, reading, data._columns))


def r2(predicted: ArrayLike, after: ArrayLike) -> float:
    """Score predicted next states: the paper's r².

    For each of the six channels, one less the sum of squared errors over the sum of squared deviations from
    the mean of `after`; then the mean over the channels that vary. That is the same as one pooled coefficient
    after each channel is divided by its standard deviation over the test.

    Parameters
    ----------
    predicted, after : array_like, shape (n, 6)
        What was predicted, and what followed.

    Returns
    -------
    float
        1 for perfect; NaN if nothing varies, minus infinity where a prediction is not finite.
    """
    states, truth = _rows("predicted", predicted, 6), _rows("after", after, 6)
    if len(states) != len(truth):
        raise TrundleError(
            f"predicted has {len(states)} rows and after {len(truth)}: one for each transition"
        )
    return _native._r2(states, truth)


class _Predictor(ABC):
    """What predicts and is scored."""

    def predict(self, before: ArrayLike, wrench: ArrayLike, dt: ArrayLike) -> Floats:
        """Predict next states.

        Parameters
        ----------
        before : array_like, shape (n, 6)
            States.
        wrench : array_like, shape (n, 3)
            Wrenches held from then on.
        dt : array_like, shape (n,) or ()
            For how long, s. A regression is right for the `dt` that it was taught.

        Returns
        -------
        ndarray, shape (n, 6)
        """
        return self._predict(*_inputs(before, wrench, dt))

    @abstractmethod
    def _predict(self, before: Floats, wrench: Floats, dt: Floats) -> Floats:
        """Predict from arrays that are checked."""

    def score(self, test: Transitions) -> float:
        """Return `r2` of the predictions of `test`."""
        return r2(self.predict(test.before, test.wrench, test.dt), test.after)


class PhysicalModel(_Predictor):
    """A model in the place of a regression, such as one that `trundle.fit` found.

    Parameters
    ----------
    model : Model
        With all values given.
    """

    def __init__(self, model: Model) -> None:
        self.model = model

    def _predict(self, before: Floats, wrench: Floats, dt: Floats) -> Floats:
        return _native._hold(self.model, before, wrench, dt)


class _Regression(_Predictor):
    def __init__(self, features: Features) -> None:
        self.features: Features = features
        self._learnt: _native._Regression | None = None

    def _predict(self, before: Floats, wrench: Floats, dt: Floats) -> Floats:
        if self._learnt is None:
            raise TrundleError("nothing is learnt yet: call fit(transitions) first")
        return self._learnt.predict(before, wrench, dt)


class LinearRegression(_Regression):
    """The paper's LR: least squares of the next state on ``[x, u, 1]``.

    Parameters
    ----------
    features : {"world", "recorded", "body"}
        State and wrench in world axes (the paper's); the wrench in object axes, as eq. 13 hands it on; or
        twist, wrench and change in object axes, where it does not matter where the object stands: a stronger
        baseline.
    """

    def __init__(self, features: Features = "world") -> None:
        super().__init__(features)

    def fit(self, training: Transitions) -> LinearRegression:
        """Learn from transitions of one `dt`, and return itself.

        Fewer of them than coefficients give the smallest coefficients that fit.

        Raises
        ------
        TrundleError
            If there are none, or a number is not finite.
        """
        self._learnt = _native._Regression.linear(training._columns, self.features)
        return self


class LocallyWeightedRegression(_Regression):
    """The paper's LWR: a linear fit around each query, weighted by a Gaussian kernel.

    The kernel's widths and a ridge are chosen by leave-one-out error on the training data alone.

    Parameters
    ----------
    features : {"world", "recorded", "body"}
        As for `LinearRegression`.
    """

    def __init__(self, features: Features = "world") -> None:
        super().__init__(features)

    def fit(self, training: Transitions) -> LocallyWeightedRegression:
        """Learn from transitions of one `dt`, and return itself.

        Raises
        ------
        TrundleError
            If there are none, or a number is not finite.
        """
        self._learnt = _native._Regression.local(training._columns, self.features)
        return self

    @property
    def widths(self) -> Floats:
        """Width of the kernel for each feature, in its unit; 1000 standard deviations where it is global."""
        widths = None if self._learnt is None else self._learnt.widths
        if widths is None:
            raise TrundleError("nothing is learnt yet: call fit(transitions) first")
        return np.array(widths)
