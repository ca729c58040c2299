"""Settings of the adaptive agent."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from trundle._native import TrundleError
from trundle.display.fields import DisplayedFields
from trundle.learners import KINDS, REGRESSIONS, Kind
from trundle.settings import SettingsError, typed

__all__ = ["AgentSettings", "read_agent_settings"]

DEFAULT_PERIOD_S = 0.05
"""Time between two actions if neither settings nor environment determine it, s."""
MAX_STARTS = 1000
"""Maximum number of random starts of a search."""


@dataclass(frozen=True, kw_only=True, repr=False)
class AgentSettings(DisplayedFields):
    """Settings of `trundle.AdaptiveAgent`.

    Attributes
    ----------
    mass : float
        Mass of the default model, kg, if the environment does not provide it.
    adapt : bool
        Whether to estimate the object. Otherwise the agent keeps its first model.
    arm : bool
        Whether to estimate delay, lag and compliance of the arm, and to plan with them. Otherwise the agent
        assumes that the wrench is the command at once.
    learner : {"body", "filter", "shooting", "linear", "local"}
        "body": a rigid body on viscous wheels (mass, mass centre, inertia, damping matrix), perhaps with dry
        friction, by linear regression of its equation of motion before each action.
        "filter": the paper's model with one wheel,
        estimated online under the default likelihood. "shooting": the same model under eq. 8 of the paper.
        "linear", "local": linear or locally weighted regression of the motion.
    diagnose : bool
        Whether to diagnose missing effects if the model predicts worse than the noise explains. The agent
        adds the named effects to its model. If none is named, it adds the best fitted candidate, if that
        predicts better.
    diagnosis_delay : float
        Time after which the agent uses the result of a diagnosis, s. Until then the diagnosis runs on
        another thread. If it is not finished, the agent waits, so that the same seed gives the same actions.
    realtime : bool
        Whether the agent uses the result of a diagnosis as soon as it is ready and never waits for it. The
        same seed may then give different actions.
    probe : bool
        Whether to start with several models: the object rolls freely, or a wheel near one corner is locked.
        While the value of information is large, the agent prefers pushes that distinguish them (dual
        control).
    outline : bool
        Whether to start with the true outline if objects vary, as a camera would see it. Otherwise the agent
        uses the outline in the observations, or else the bounding box. For one environment at a time.
    push : float
        Duration that counts as one push, s. Learners other than "body" update after each push once the value
        of information is small.
    pushes : int, optional
        Number of such intervals after which learning stops; by default it never stops.
    starts : int
        Number of random starts of each search, 1 to 1000.
    period : float, optional
        Time between two actions, s; by default the environment's `control`, or 0.05.
    rise : float
        Time in which the wrench changes from one action to the next without lag, s.
    seed : int
        Seed of plans and searches. The same seed and observations give the same actions.
    rollouts : int
        Maximum number of rollouts, each of one plan on one model, for a plan and again for the value of
        information. It bounds the time of a decision: with several models the planner samples fewer plans.
    planner : mapping
        Settings of `trundle.Planner`.

    Raises
    ------
    TrundleError
        If a value is out of its range, or two settings contradict each other.

    Examples
    --------
    >>> trundle.AgentSettings(diagnose=True, planner={"samples": 512}).learner
    'body'
    """

    mass: float = 22.0
    adapt: bool = True
    arm: bool = True
    learner: Kind = "body"
    diagnose: bool = False
    diagnosis_delay: float = 0.0
    realtime: bool = False
    probe: bool = False
    outline: bool = False
    push: float = 0.5
    pushes: int | None = None
    starts: int = 2
    period: float | None = None
    rise: float = 0.02
    seed: int = 0
    rollouts: int = 1536
    planner: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.mass > 0:
            raise TrundleError(f"mass = {self.mass}: must be positive (kg)")
        if not 1 <= self.starts <= MAX_STARTS:
            raise TrundleError(f"starts = {self.starts}: must be 1 to {MAX_STARTS}")
        if not 0.0 <= self.diagnosis_delay < float("inf"):
            raise TrundleError(
                f"diagnosis_delay = {self.diagnosis_delay}: must be finite and not negative (s); "
                "realtime = True never waits"
            )
        if not 0 <= self.seed < 2**63:
            raise TrundleError(f"seed = {self.seed}: must be an integer from 0 to 2**63 - 1")
        if self.pushes is not None and self.pushes < 1:
            raise TrundleError(f"pushes = {self.pushes}: must be at least 1; adapt = False disables learning")
        if self.learner not in KINDS:
            raise TrundleError(f"learner = {self.learner!r}: choose one of {', '.join(KINDS)}")
        if self.learner in REGRESSIONS and self.diagnose:
            raise TrundleError(
                f"learner = {self.learner!r}, diagnose = True: a regression cannot be diagnosed; "
                "choose 'filter' or 'shooting'"
            )
        if self.probe and self.learner == "body":
            raise TrundleError(
                "probe = True, learner = 'body': it has one most probable model; choose learner = 'filter'"
            )
        if not self.adapt and (self.diagnose or self.probe):
            raise TrundleError(
                f"adapt = False, diagnose = {self.diagnose}, probe = {self.probe}: these need adapt = True"
            )

    def control_period(self, env: Any) -> float:
        """Return the time between two actions in an environment, s.

        Raises
        ------
        TrundleError
            If it does not lie between `rise` and `push`.
        """
        of_env = float(getattr(env, "control", DEFAULT_PERIOD_S))
        period = of_env if self.period is None else self.period
        if not 0 < self.rise < period <= self.push:
            raise TrundleError(
                f"rise = {self.rise}, period = {period}, push = {self.push}: give rise < period <= push (s); "
                "the default period is that of the environment"
            )
        return period


def read_agent_settings(path: Path, table: Mapping[str, Any], where: str) -> AgentSettings:
    """Build settings from a table of a TOML file; an error names the file and the key.

    Parameters
    ----------
    path : Path
        The file, for messages.
    table : mapping
        The parsed table.
    where : str
        Key of the table, for messages.

    Raises
    ------
    TrundleError
        If a key is unknown or of another type, or a value is not allowed.
    """
    try:
        return typed(AgentSettings, table, where)
    except SettingsError as error:
        raise TrundleError(f"{path}: {error}") from error
    except TrundleError as error:
        raise TrundleError(f"{path}: [{where}] {error}") from error
