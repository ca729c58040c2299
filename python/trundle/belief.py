"""The observations of an episode and the models that an adaptive agent has estimated from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from trundle._native import Laws, Model, Planner, Recording, _ArmEstimate, _BodyRegression, _Regression
from trundle.background import Background
from trundle.display import Card, Displayed, Table
from trundle.envs.observation import Observation
from trundle.missing_effects import Extension
from trundle.online import Online
from trundle.report.quantity import format_estimate

__all__ = ["Belief", "Update", "observation_metadata"]

Array: TypeAlias = NDArray[np.float64]

RELEASE_TIME_S = 1e-4
"""Time in which the wrench drops to zero after the gripper releases the object, s."""


@dataclass(frozen=True, repr=False)
class Update(Displayed):
    """Result of one fit.

    Attributes
    ----------
    time : float
        Time since the start of the episode, s.
    model : Model
        The most probable model, fitted to all observations so far.
    estimate : list of dict
        ``name``, ``mean``, ``sd`` (None if the parameter is not identifiable) and ``unit`` of each parameter.
    named : tuple of str
        Effects that a diagnosis named at this time.
    supposed : tuple of str
        Effects that the agent adds although no diagnosis named them: the best candidate leaves a lack of fit
        but predicts better.
    value_of_information : float
        Expected gain from knowing the true model, m s, as `Planner.regret` computes it; 0 if it was not
        computed.
    regrasp : tuple of float, optional
        Grasp point to which the gripper moves, object frame, m.
    """

    time: float
    model: Model
    estimate: Sequence[Mapping[str, Any]]
    named: tuple[str, ...] = ()
    supposed: tuple[str, ...] = ()
    value_of_information: float = 0.0
    regrasp: tuple[float, float] | None = None

    def _card(self) -> Card:
        rows = [(one["name"], format_estimate(one["mean"], one["sd"]), one["unit"]) for one in self.estimate]
        named = ", ".join((*self.named, *(f"{name} (supposed)" for name in self.supposed)))
        facts = [("named effects", named)] if named else []
        return Card(
            f"trundle.agent.Update at {self.time:.2f} s",
            facts,
            Table(("parameter", "estimate", "unit"), rows),
        )


@dataclass(frozen=True)
class PendingDiagnosis:
    """A diagnosis on a thread of its own.

    Attributes
    ----------
    work : Background
        Its work.
    started, due : float
        Times of its start and of the use of its result, s since the start of the episode.
    """

    work: Background[Extension]
    started: float
    due: float


class Belief(Displayed):
    """The observations of one episode and the models estimated from them.

    Parameters
    ----------
    model : Model
        Model at the start of the episode.
    planner : Planner
        Planner of this episode. It keeps its last plan between calls.
    metadata : dict
        Content of ``recording.toml`` for a recording of the observations.
    first : Observation
        Observation after the reset.
    arm : _ArmEstimate, optional
        Estimate of the arm's response; None: the wrench is the command at once.

    Attributes
    ----------
    models : tuple of Model
        Models that the planner uses, the most probable one first.
    updates : list of Update
        Results of the fits, in order.
    observations : list of Observation
        All observations, the latest last.
    plan : list of ndarray
        Remaining actions of the current plan, shape (3,) each.
    diagnosed_at : float
        Time of the observations of the last completed diagnosis, s since the start of the episode; 0: none.
    diagnosis : PendingDiagnosis, optional
        The diagnosis in progress.
    next_grasp : ndarray or None
        Grasp point to which the gripper is moving, object frame, m.
    has_released : bool
        Whether the action that releases the object for `next_grasp` has been sent.
    template : Model or None
        Model with free parameters that is fitted; None: the paper's model.
    online : Online, optional
        Online estimate of the parameters of `template`.
    online_since : float
        Time of the first observation of the current push of `online`, s. Earlier ones are a push of their
        own.
    body : optional
        Regression of mass, mass centre, inertia and damping; None: not started, or another learner.
    regression : _Regression or callable, optional
        Prediction of the motion that the planner uses instead of `models`; see `trundle.Planner.plan`.
    command : ndarray, shape (3,)
        Last command: a wrench at the grasp, object axes, N and N m.
    """

    def __init__(
        self,
        model: Model,
        planner: Planner,
        metadata: dict[str, Any],
        first: Observation,
        arm: _ArmEstimate | None = None,
    ) -> None:
        self.models: tuple[Model, ...] = (model,)
        self.planner = planner
        self.metadata = metadata
        self.updates: list[Update] = []
        self.template: Model | None = None
        self.online: Online | None = None
        self.online_since = 0.0
        self.body: _BodyRegression | None = None
        self.regression: _Regression | Callable[[Array], Array] | None = None
        self.diagnosed_at = 0.0
        self.diagnosis: PendingDiagnosis | None = None
        self.plan: list[Array] = []
        self.observations: list[Observation] = [first]
        self.next_grasp: Array | None = None
        self.has_released = False
        self.arm = arm
        self.command: Array = np.zeros(3)

    def _card(self) -> Card:
        facts = [
            ("models", str(len(self.models))),
            ("updates", str(len(self.updates))),
            ("observations", str(len(self.observations))),
        ]
        if self.arm is not None:
            facts.append(("arm", repr(self.arm)))
        return Card("trundle.agent.Belief", facts)

    def observe(self, observation: Observation) -> None:
        """Add the observation at the end of the action `command`."""
        if self.arm is not None:
            holds = self.next_grasp is None and np.array_equal(observation.grasp, self.latest.grasp)
            self.arm.observe(self.command, observation.wrench, holds)
        self.observations.append(observation)

    def end(self) -> None:
        """Stop work in progress."""
        if self.diagnosis is not None:
            self.diagnosis.work.cancel()

    @property
    def model(self) -> Model:
        """The most probable model."""
        return self.models[0]

    @property
    def fits(self) -> int:
        """Number of fits so far."""
        return len(self.updates)

    @property
    def latest(self) -> Observation:
        """The latest observation."""
        return self.observations[-1]

    @property
    def situation(self) -> tuple[Array, Array, Array]:
        """Pose and twist of the object, and goal pose, shape (3,) each, world frame, for the planner."""
        return self.latest.pose, self.latest.twist, self.latest.goal_pose

    def inner_states(self, period: float) -> list[float]:
        """Return the present inner states of the model's laws, such as the angle of a caster.

        The states are integrated along the observed motion.

        Parameters
        ----------
        period : float
            Time between two observations, s.
        """
        laws = Laws(self.model)
        states = laws.starts
        if not states:
            return states
        for before, after in zip(self.observations, self.observations[1:], strict=False):
            wrench = about_origin(after.wrench, before.grasp)
            *_, states = laws.step(before.pose, before.twist, wrench, period, inner=states)
        return states

    def recording(self, period: float, rise: float) -> Recording:
        """Return the observations as a recording with one episode; see `columns`."""
        return Recording(self.metadata, {"episode_00": self.columns(period, rise)})

    def columns(self, period: float, rise: float) -> dict[str, Array]:
        """Return the observations as the table of an episode.

        Each action has a reading of the wrench at its end, and one when the wrench reaches the command. If
        the arm is not ideal, it has several wrenches in between, by the estimated response.

        Parameters
        ----------
        period : float
            Time between two observations, s.
        rise : float
            Time in which the wrench changes from one action to the next, s.
        """
        seen = self._batch()
        (x, y), (cos, sin), heading = seen.position.T, seen.direction.T, seen.heading
        (grasp_x, grasp_y), (force_x, force_y) = seen.grasp.T, seen.force.T
        table = {
            "t": period * np.arange(len(x)),
            "object_x": x,
            "object_y": y,
            "object_theta": heading,
            "gripper_x": x + cos * grasp_x - sin * grasp_y,
            "gripper_y": y + sin * grasp_x + cos * grasp_y,
            "gripper_theta": heading,
            "force_x": force_x,
            "force_y": force_y,
            "torque_z": seen.torque,
        }
        times, wrenches = self._wrenches_within(seen, rise)
        inner = {key: np.full(times.size, np.nan) for key in table}
        inner["t"] = (table["t"][:-1, None] + times).ravel()
        inner |= zip(("force_x", "force_y", "torque_z"), wrenches.reshape(-1, 3).T, strict=True)
        order = np.argsort(np.concatenate([table["t"], inner["t"]]))
        return {key: np.concatenate([table[key], inner[key]])[order] for key in table}

    def _wrenches_within(self, seen: Observation, rise: float) -> tuple[Array, Array]:
        """Return times since the start of each action (n, k) and wrenches at them (n, k, 3).

        When the gripper releases the object, the wrench drops at once.
        """
        released = is_regrasping(seen)
        wrenches = None if self.arm is None else self.arm.wrenches()
        if self.arm is None or wrenches is None:
            # After the rise the wrench is constant and equals the reading at the end of the action.
            return np.where(released, RELEASE_TIME_S, rise)[:, None], seen.wrench[1:, None]
        times = np.tile(self.arm.knots, (len(wrenches), 1))
        times[released, 0] = RELEASE_TIME_S
        return times, wrenches

    def transitions(self, period: float, rise: float) -> tuple[Array, Array, Array, Array]:
        """Return states before, mean wrenches about the object's origin, durations, and states after.

        Shapes (n, 6), (n, 3), (n,), (n, 6); units and frames as in `trundle.baselines`. `period` and `rise`
        are those of `columns`.
        """
        seen = self._batch()
        states = np.column_stack([seen.position, np.unwrap(seen.heading), seen.twist])
        times, within = self._wrenches_within(seen, rise)
        ends = np.zeros((len(times), 1)), np.full((len(times), 1), period)
        steps = np.diff(np.concatenate([ends[0], times, ends[1]], axis=1), axis=1)[..., None]
        wrenches = np.concatenate([seen.wrench[:-1, None], within, seen.wrench[1:, None]], axis=1)
        mean = ((wrenches[:, 1:] + wrenches[:, :-1]) / 2 * steps).sum(axis=1) / period
        wrench = about_origin(mean.T, seen.grasp[:-1].T).T
        return states[:-1], np.ascontiguousarray(wrench), np.full(len(mean), period), states[1:]

    def _batch(self) -> Observation:
        """Return all observations as one batch, shape (n, entries)."""
        return Observation(np.array([one.vector for one in self.observations]))


def is_regrasping(observations: Observation) -> NDArray[np.bool_]:
    """Return for each step of a batch whether the gripper moved to another grasp point; shape (n - 1,)."""
    moved: NDArray[np.bool_] = np.any(observations.grasp[1:] != observations.grasp[:-1], axis=1)
    return moved


def about_origin(wrench: Array, grasp: Array) -> Array:
    """Return wrenches at the grasp points as wrenches about the object's origin, object axes.

    Parameters
    ----------
    wrench : ndarray, shape (3, ...)
        Force (N) and torque about the grasp point (N m), components along the first axis.
    grasp : ndarray, shape (2, ...)
        Grasp points, object frame, m.
    """
    return np.stack([wrench[0], wrench[1], wrench[2] + grasp[0] * wrench[1] - grasp[1] * wrench[0]])


def observation_metadata(metadata: dict[str, Any]) -> dict[str, Any]:
    """Return the metadata of a recording of observations, from those of the environment.

    Observed wrenches are tared. The scene is omitted, because the agent keeps away from obstacles.
    """
    wrench = {"frame": "sensor", "sign": "on_object", "raw": False, "contact": "grasp"}
    return {**{key: value for key, value in metadata.items() if key != "scene"}, "wrench": wrench}
