"""Transitions between states, and the score of predicted states; public in `trundle.baselines`."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trundle import _native
from trundle._native import Model, Recording, TrundleError
from trundle.display import Card, Displayed

__all__ = ["Floats", "Transitions", "inputs", "noise_sd", "r2"]

Floats: TypeAlias = NDArray[np.float64]


def table(name: str, values: ArrayLike, width: int) -> Floats:
    """Return a validated table of `width` columns."""
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != width:
        raise TrundleError(f"{name}: has the shape {array.shape}; give (n, {width})")
    return array


def inputs(before: ArrayLike, wrench: ArrayLike, dt: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Return validated states (n, 6), wrenches (n, 3) and durations (n,)."""
    states, wrenches = table("before", before, 6), table("wrench", wrench, 3)
    if len(wrenches) != len(states):
        raise TrundleError(
            f"before has {len(states)} rows and wrench {len(wrenches)}: one for each transition"
        )
    times = np.asarray(dt, dtype=np.float64)
    if times.shape not in [(), (len(states),)]:
        raise TrundleError(f"dt: has the shape {times.shape}; give one number, or ({len(states)},)")
    return states, wrenches, np.broadcast_to(times, (len(states),)).copy()


@dataclass(frozen=True, eq=False, repr=False)
class Transitions(Displayed):
    """Observations (eq. 7).

    Attributes
    ----------
    before : ndarray, shape (n, 6)
        States.
    wrench : ndarray, shape (n, 3)
        Constant wrenches applied to these states.
    dt : ndarray, shape (n,)
        Duration, s; a single number applies to all.
    after : ndarray, shape (n, 6)
        Next states.

    Examples
    --------
    >>> import trundle
    >>> from trundle import baselines
    >>> chair = trundle.objects.read("configs/objects/chair.toml").models["free"]
    >>> data = baselines.Transitions.simulated(chair, 50, seed=0)
    >>> len(data), data.before.shape, data.wrench.shape
    (50, (50, 6), (50, 3))
    >>> len(data[:10])
    10
    """

    before: Floats
    wrench: Floats
    dt: Floats
    after: Floats

    def __post_init__(self) -> None:
        before, wrench, dt = inputs(self.before, self.wrench, self.dt)
        after = table("after", self.after, 6)
        if len(after) != len(before):
            raise TrundleError(
                f"before has {len(before)} rows and after {len(after)}: one for each transition"
            )
        for name, value in [("before", before), ("wrench", wrench), ("dt", dt), ("after", after)]:
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.before)

    def _card(self) -> Card:
        return Card(f"trundle.baselines.Transitions: {len(self)} transitions, {self.dt.sum():.4g} s in total")

    def __getitem__(self, rows: slice | Floats | NDArray[np.bool_] | NDArray[np.int64]) -> Transitions:
        """Return a subset of the transitions."""
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
        """Simulate pushes of a model without contacts and noise.

        Each push has a random target twist, as with a velocity-controlled gripper: its wrench accelerates the
        object to that twist within `dt` and compensates friction. Training and test data use the same
        procedure.

        Parameters
        ----------
        model : Model
            Must contain a value for every parameter.
        n : int
            Number of transitions. A smaller number gives a prefix of a larger one.
        seed : int
            Random seed.
        dt : float
            Duration of each wrench, s.
        per_episode : int
            Number of pushes from each random start at rest.
        speed, spin : float
            Standard deviation of the target twist: along each axis, m/s, and of the spin, rad/s.
        force : float
            Maximum force, N.
        arena, heading : float
            Maximum distance along each axis, m, and heading, rad, of the start of episodes.

        Returns
        -------
        Transitions

        Raises
        ------
        TrundleError
            If a parameter of the model has no value, or a setting is invalid.
        """
        settings = {"dt": dt, "per_episode": per_episode, "speed": speed, "spin": spin}
        settings |= {"force": force, "arena": arena, "heading": heading}
        return cls(*_native._transitions(model, n, seed, settings))

    @classmethod
    def recorded(
        cls, recording: Recording | str | os.PathLike[str], *, dt: float = 0.2, held_out: bool = False
    ) -> Transitions:
        """Cut a recording into transitions, so that regressions use the data of a fit.

        Parameters
        ----------
        recording : Recording or path-like
            The recording, or its folder.
        dt : float
            Length of an interval, s. Intervals in a gap of poses or wrenches are omitted.
        held_out : bool
            Whether to use the held-out episodes instead of the training episodes.

        Returns
        -------
        Transitions
            States are smoothed over all poses of an episode. The wrench is the tared mean over the interval.

        Raises
        ------
        TrundleError
            If the recording cannot be prepared.
        """
        return cls(*_native._cut(recording, dt, held_out))

    def with_noise(self, sd: ArrayLike, *, seed: int = 0) -> Transitions:
        """Add normal noise to the next states only.

        Parameters
        ----------
        sd : array_like, shape (6,) or ()
            Standard deviation of each channel, SI units, as from `noise_sd`.
        seed : int
            Random seed of the noise.

        Returns
        -------
        Transitions
        """
        deviations = np.broadcast_to(np.asarray(sd, dtype=np.float64), (6,)).tolist()
        return replace(self, after=_native._noisy(self._columns, deviations, seed))


def noise_sd(sigma: float, reading: Literal["si", "cm_deg", "of_motion"], data: Transitions) -> Floats:
    """Return the standard deviation in each channel for a σ without units, as in the paper.

    Parameters
    ----------
    sigma : float
        The σ.
    reading : {"si", "cm_deg", "of_motion"}
        In m, rad, m/s and rad/s; in cm, degrees, cm/s and degrees/s; or as a multiple of the standard
        deviation of each channel's change over `data`.
    data : Transitions
        Transitions without noise.

    Returns
    -------
    ndarray, shape (6,)
        Standard deviations, SI units.

    Examples
    --------
    >>> import trundle
    >>> from trundle import baselines
    >>> chair = trundle.objects.read("configs/objects/chair.toml").models["free"]
    >>> data = baselines.Transitions.simulated(chair, 50, seed=0)
    >>> baselines.noise_sd(0.01, "si", data)
    array([0.01, 0.01, 0.01, 0.01, 0.01, 0.01])
    """
    return np.array(_native._noise_sd(sigma, reading, data._columns))


def r2(predicted: ArrayLike, after: ArrayLike) -> float:
    """Compute the r² of predicted next states, as in the paper.

    For each of the six channels it is one minus the ratio of the sum of squared errors to the sum of squared
    deviations from the mean of `after`. The result is the mean over the channels that vary. It equals a
    pooled coefficient of channels that are normalised by their standard deviations.

    Parameters
    ----------
    predicted, after : array_like, shape (n, 6)
        Predicted and true next states.

    Returns
    -------
    float
        1 for a perfect prediction; NaN if no channel varies; minus infinity if a prediction is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> from trundle import baselines
    >>> after = np.random.default_rng(0).normal(size=(20, 6))
    >>> baselines.r2(after, after)
    1.0
    """
    states, truth = table("predicted", predicted, 6), table("after", after, 6)
    if len(states) != len(truth):
        raise TrundleError(
            f"predicted has {len(states)} rows and after {len(truth)}: one for each transition"
        )
    return _native._r2(states, truth)
