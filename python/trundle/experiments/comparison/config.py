"""Settings of a comparison: worlds, agents, and which agents run where."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from trundle.agent_settings import AgentSettings, read_agent_settings
from trundle.rules import Count, EnvOptions, Natural, Positive, Rule, pattern
from trundle.settings import SettingsError, read_settings

__all__ = ["Agent", "Settings", "Target", "Trial", "Worlds", "read"]

FORMAT = "trundle-compare/1"


@dataclass(frozen=True)
class Worlds:
    """A group of worlds: an environment and a range of its seeds.

    Attributes
    ----------
    title : str
        Title in the document.
    env : str
        Id of the environment.
    first, count : int
        The seeds are `first` to `first + count - 1`.
    agents : list of str
        Agents that run in these worlds.
    options : dict
        Arguments of the environment.
    effect : list of dict
        Further effects, drawn for each world; see `trundle.experiments.comparison.world.draw_effects`.
    simulator : {"trundle", "mujoco"}
        What computes the motion; see `trundle.experiments.comparison.mujoco_plant.MujocoPlant`.
    """

    title: str
    env: str
    first: Natural
    count: Count
    agents: list[str]
    options: EnvOptions = field(default_factory=dict)
    effect: list[dict[str, Any]] = field(default_factory=list)
    simulator: Literal["trundle", "mujoco"] = "trundle"

    @property
    def identity(self) -> dict[str, Any]:
        """Everything except the seed that an episode depends on."""
        return {
            "env": self.env,
            "options": self.options,
            "effect": self.effect,
            "simulator": self.simulator,
        }

    @property
    def seeds(self) -> range:
        """The seeds."""
        return range(self.first, self.first + self.count)


@dataclass(frozen=True)
class Agent:
    """An agent.

    Attributes
    ----------
    title : str
        Title in the document.
    kind : {"oracle", "adaptive", "policy", "dynamics"}
        `trundle.AdaptiveAgent` with the true model and without adaptation; the same with its own belief; a
        policy of stable-baselines3; or the planner of the adaptive agent on a learned dynamics model.
    settings : dict
        Fields of `trundle.AgentSettings`.
    files : list of str
        Files of a policy or a dynamics model, one for each training run. Each run is evaluated in all worlds.
    options : dict
        Arguments of the environment that differ for this agent, such as `action`.
    curve : str
        `config` of a policy's learning curves.
    """

    title: str
    kind: Literal["oracle", "adaptive", "policy", "dynamics"]
    settings: dict[str, Any] = field(default_factory=dict)
    files: list[str] = field(default_factory=list)
    options: EnvOptions = field(default_factory=dict)
    curve: str = ""

    def __post_init__(self) -> None:
        if self.is_trained != bool(self.files):
            raise SettingsError(
                "files: required for a policy or a dynamics model, not allowed for other agents"
            )
        if self.is_trained and self.settings:
            raise SettingsError(
                "settings: not allowed for a trained agent; they are fields of trundle.AgentSettings"
            )

    @property
    def is_trained(self) -> bool:
        """Whether `trundle train` made the agent."""
        return self.kind in ("policy", "dynamics")

    @property
    def agent_settings(self) -> AgentSettings:
        """Settings of an adaptive agent or an oracle."""
        return AgentSettings(**self.settings)

    @property
    def identity(self) -> dict[str, Any]:
        """Everything except the trained file that an episode depends on."""
        return {"kind": self.kind, "settings": self.settings, "options": self.options}

    @property
    def learns(self) -> bool:
        """Whether the agent adapts during an episode."""
        return self.kind == "adaptive" and bool(self.settings.get("adapt", True))

    @property
    def runs(self) -> range:
        """Run numbers: one for each file of a policy or a dynamics model."""
        return range(len(self.files) or 1)


@dataclass(frozen=True)
class Target:
    """Target of a figure of an agent in a group of worlds: `least` or `most`."""

    worlds: str
    agent: str
    figure: Literal["success", "success without touching", "quick success", "regret"]
    least: float | None = None
    most: float | None = None

    def __post_init__(self) -> None:
        if (self.least is None) == (self.most is None):
            raise SettingsError("give least or most")


class Trial(NamedTuple):
    """An episode: names of worlds and agent, number of the training run, seed."""

    worlds: str
    agent: str
    run: int
    seed: int


@dataclass(frozen=True)
class Settings:
    """Settings of a comparison.

    Attributes
    ----------
    name : str
        Name of the document and of the folder of its results.
    title : str
        Heading of the document.
    worlds, agents : dict
        By name, in order.
    main : str
        Name of the agent that the others are compared with.
    push : float
        Duration that counts as one push, s.
    pairs : list of (str, str)
        Pairs of agents that differ in one component. The first one has it.
    targets : list of Target
    training : str
        Folder of `trundle train` with the curves of the policies; by default the folder of the results.
    """

    name: Annotated[str, pattern(r"[\w-]+", "a name of letters, digits, _ or -")]
    title: str
    worlds: Annotated[dict[str, Worlds], Rule(bool, "at least one table [worlds.NAME]")]
    agents: dict[str, Agent]
    main: str
    push: Positive = 0.5
    pairs: list[tuple[str, str]] = field(default_factory=list)
    targets: list[Target] = field(default_factory=list)
    training: str = ""

    def __post_init__(self) -> None:
        check_names("main: unknown agent", [self.main], self.agents)
        for name, worlds in self.worlds.items():
            check_names(f"[worlds.{name}] agents: unknown agent", worlds.agents, self.agents)
        for pair in self.pairs:
            check_names("pairs: unknown agent", pair, self.agents)
        check_names("targets: unknown agent", (one.agent for one in self.targets), self.agents)
        check_names("targets: unknown worlds", (one.worlds for one in self.targets), self.worlds)

    @property
    def trials(self) -> list[Trial]:
        """Every episode, in the order of the results."""
        return [
            Trial(name, agent, run, seed)
            for name, worlds in self.worlds.items()
            for agent in worlds.agents
            for run in self.agents[agent].runs
            for seed in worlds.seeds
        ]


def check_names(complaint: str, names: Iterable[str], known: Collection[str]) -> None:
    """Raise an error for a name that is not known."""
    for name in names:
        if name not in known:
            raise SettingsError(f"{complaint} {name!r}; choose from {', '.join(known)}")


def read(path: Path) -> Settings:
    """Read the file of a comparison.

    Raises
    ------
    TrundleError
        If a key is missing, unknown or of another type, or a name is not defined.
    """
    settings = read_settings(path, FORMAT, Settings)
    for name, agent in settings.agents.items():
        read_agent_settings(path, agent.settings, f"agents.{name}.settings")
    return settings
