"""Calls of the user's `step` function for joints, with checks of what it returns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NoReturn, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trundle._native import TrundleError

__all__ = ["JointSimulator", "JointStep", "Samples"]

Floats: TypeAlias = NDArray[np.float64]
JointStep: TypeAlias = Callable[[Floats, Floats, float, dict[str, float]], ArrayLike]


class Samples:
    """Episode and times, s, of the samples of a call, for messages."""

    def __init__(self, episode: str, t: ArrayLike) -> None:
        self.episode = episode
        self.t = np.atleast_1d(np.asarray(t, dtype=float))

    def rows(self, rows: Any) -> Samples:
        """Return some of the samples."""
        return Samples(self.episode, self.t[rows])

    def __getitem__(self, row: int) -> str:
        return f"episode {self.episode}, t = {self.t[row]:.6g} s"


class JointSimulator:
    """A black-box simulator of n joints.

    Parameters
    ----------
    step : callable
        ``step(state, effort, dt, values)`` returns the state after `dt` seconds: see `trundle.diagnose`.
    joints : sequence of str
        Their order is that of positions, velocities and efforts.
    vectorized : bool
        Whether `step` takes states (B, 2n) and efforts (B, n).
    """

    def __init__(self, step: JointStep, joints: Sequence[str], *, vectorized: bool = False) -> None:
        if not callable(step):
            raise TrundleError(f"step = {step!r}: must be a function step(state, effort, dt, values)")
        self.function, self.joints, self.vectorized = step, tuple(joints), vectorized

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joints)

    def step(
        self, states: Floats, efforts: Floats, dt: float, values: Mapping[str, float], samples: Samples
    ) -> Floats:
        """Return the states, (B, 2n), after `dt` seconds.

        Raises
        ------
        TrundleError
            If the function raises or returns anything but finite numbers of the right shape. The message
            names the episode, the time and the joint.
        """
        after = self.call(states, efforts, dt, values, samples)
        wrong = np.argwhere(~np.isfinite(after))
        if len(wrong):
            row, column = wrong[0]
            quantity = "position" if column < self.n else "velocity"
            self._refuse(
                f"returned {after[row, column]} as the {quantity} of joint {self.joints[column % self.n]}",
                "make it return finite numbers for every state of the recorded motion",
                (states[row], efforts[row], dt, values, samples[row]),
            )
        return after

    def call(
        self, states: Floats, efforts: Floats, dt: float, values: Mapping[str, float], samples: Samples
    ) -> Floats:
        """Return the states as `step`, without a check for finite numbers."""
        if self.vectorized:
            return self._call(states.copy(), efforts.copy(), dt, values, samples[0])
        rows = [
            self._call(state.copy(), effort.copy(), dt, values, samples[k])
            for k, (state, effort) in enumerate(zip(states, efforts, strict=True))
        ]
        return np.stack(rows)

    def _call(
        self, state: Floats, effort: Floats, dt: float, values: Mapping[str, float], place: str
    ) -> Floats:
        arguments = (state.copy(), effort.copy(), dt, values, place)
        try:
            found = self.function(state, effort, dt, dict(values))
        except Exception as error:
            problem = f"raised {type(error).__name__}: {error}"
            self._refuse(problem, "call it with these arguments to find the cause", arguments, error)
        try:
            after = np.array(found, dtype=float)
        except (TypeError, ValueError) as error:
            remedy = f"return {self._wanted(state)}"
            self._refuse(f"returned {type(found).__name__}, not numbers", remedy, arguments, error)
        if after.shape != state.shape:
            problem = f"returned an array of shape {after.shape}"
            self._refuse(problem, f"return {self._wanted(state)}", arguments)
        return after

    def _wanted(self, state: Floats) -> str:
        count = f"{2 * self.n} numbers" if state.ndim == 1 else f"an array of shape {state.shape}"
        return f"{count}: the positions of {', '.join(self.joints)}, then their velocities"

    def _refuse(
        self, problem: str, remedy: str, arguments: tuple[Any, ...], cause: BaseException | None = None
    ) -> NoReturn:
        state, effort, dt, values, place = arguments
        shown = f"state = {_show(state)}, effort = {_show(effort)}, dt = {dt:.6g}, values = {dict(values)}"
        raise TrundleError(f"step: {place}: {problem}; {remedy} ({shown})") from cause


def _show(values: Floats) -> str:
    """Return an array in one line; of many rows the first."""
    row = values if values.ndim == 1 else values[0]
    text = ", ".join(f"{value:.6g}" for value in row)
    return f"[{text}]" if values.ndim == 1 else f"array of shape {values.shape} with first row [{text}]"
