"""Section V-B of the paper: models learned from transitions, and the score that compares them.

A transition is a state, the constant wrench applied from then on, and the next state. States are rows
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

from abc import ABC, abstractmethod
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from trundle import _native
from trundle._native import Model, TrundleError
from trundle.transitions import Floats, Transitions, inputs, noise_sd, r2

__all__ = [
    "LinearRegression",
    "LocallyWeightedRegression",
    "PhysicalModel",
    "Transitions",
    "noise_sd",
    "r2",
]


def __dir__() -> list[str]:
    return __all__


Features: TypeAlias = Literal["world", "recorded", "body"]


class _Predictor(ABC):
    """Base class of models that predict next states."""

    def predict(self, before: ArrayLike, wrench: ArrayLike, dt: ArrayLike) -> Floats:
        """Predict next states.

        Parameters
        ----------
        before : array_like, shape (n, 6)
            States.
        wrench : array_like, shape (n, 3)
            Constant wrenches applied to these states.
        dt : array_like, shape (n,) or ()
            Duration, s. A regression is valid only for the `dt` of its training data.

        Returns
        -------
        ndarray, shape (n, 6)
        """
        return self._predict(*inputs(before, wrench, dt))

    @abstractmethod
    def _predict(self, before: Floats, wrench: Floats, dt: Floats) -> Floats:
        """Predict from validated arrays."""

    def score(self, test: Transitions) -> float:
        """Return the `r2` of the predictions on `test`."""
        return r2(self.predict(test.before, test.wrench, test.dt), test.after)


class PhysicalModel(_Predictor):
    """A physical model, such as the result of `trundle.fit`, with the interface of a regression.

    Parameters
    ----------
    model : Model
        Must contain a value for every parameter.

    Examples
    --------
    >>> import trundle
    >>> from trundle import baselines
    >>> chair = trundle.objects.read("configs/objects/chair.toml").models["free"]
    >>> test = baselines.Transitions.simulated(chair, 20, seed=1)
    >>> baselines.PhysicalModel(chair).score(test) > 0.999
    True
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
            raise TrundleError("the regression is not fitted: call fit(transitions) first")
        return self._learnt.predict(before, wrench, dt)


class LinearRegression(_Regression):
    """Linear regression (LR) of the paper: least squares of the next state on ``[x, u, 1]``.

    Parameters
    ----------
    features : {"world", "recorded", "body"}
        "world": state and wrench in world axes, as in the paper; "recorded": wrench in object axes, as from
        eq. 13; "body": twist, wrench and change in object axes, independent of the pose, which is a stronger
        baseline.

    Examples
    --------
    >>> import trundle
    >>> from trundle import baselines
    >>> chair = trundle.objects.read("configs/objects/chair.toml").models["free"]
    >>> training = baselines.Transitions.simulated(chair, 50, seed=0)
    >>> test = baselines.Transitions.simulated(chair, 200, seed=1)
    >>> baselines.LinearRegression(features="body").fit(training).score(test) > 0.99
    True
    """

    def __init__(self, features: Features = "world") -> None:
        super().__init__(features)

    def fit(self, training: Transitions) -> LinearRegression:
        """Fit to transitions with one `dt`, and return itself.

        With fewer transitions than coefficients, the result is the minimum-norm solution.

        Raises
        ------
        TrundleError
            If there are no transitions, or a number is not finite.
        """
        self._learnt = _native._Regression.linear(training._columns, self.features)
        return self


class LocallyWeightedRegression(_Regression):
    """Locally weighted regression (LWR) of the paper: a linear fit around each query with a Gaussian kernel.

    The kernel widths and a ridge are chosen by leave-one-out error on the training data.

    Parameters
    ----------
    features : {"world", "recorded", "body"}
        As for `LinearRegression`.

    Examples
    --------
    >>> import trundle
    >>> from trundle import baselines
    >>> chair = trundle.objects.read("configs/objects/chair.toml").models["free"]
    >>> training = baselines.Transitions.simulated(chair, 50, seed=0)
    >>> fitted = baselines.LocallyWeightedRegression().fit(training)
    >>> fitted.predict(training.before, training.wrench, 0.2).shape
    (50, 6)
    """

    def __init__(self, features: Features = "world") -> None:
        super().__init__(features)

    def fit(self, training: Transitions) -> LocallyWeightedRegression:
        """Fit to transitions with one `dt`, and return itself.

        Raises
        ------
        TrundleError
            If there are no transitions, or a number is not finite.
        """
        self._learnt = _native._Regression.local(training._columns, self.features)
        return self

    @property
    def widths(self) -> Floats:
        """Kernel width of each feature, in its unit; 1000 standard deviations if the fit is global in it."""
        widths = None if self._learnt is None else self._learnt.widths
        if widths is None:
            raise TrundleError("the regression is not fitted: call fit(transitions) first")
        return np.array(widths)
