"""Read the file of a comparison: worlds, agents, and which agents run where."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from trundle.agent import AdaptiveAgent
from trundle.recording import TrundleError
from trundle.settings import build_settings, check_argument_types, check_horizon, parse_format

__all__ = ["Agent", "Settings", "Target", "Worlds", "read"]

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
    """

    title: str
    env: str
    first: int
    count: int
    agents: list[str]
    options: dict[str, Any] = field(default_factory=dict)
    effect: list[dict[str, Any]] = field(default_factory=list)

    @property
    def identity(self) -> dict[str, Any]:
        """Everything except the seed that an episode depends on."""
        return {"env": self.env, "options": self.options, "effect": self.effect}

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
    kind : {"oracle", "adaptive", "policy"}
        `trundle.AdaptiveAgent` with the true model and without adaptation; the same with its own belief; or a
        policy of stable-baselines3.
    settings : dict
        Arguments of `trundle.AdaptiveAgent`.
    files : list of str
        Files of a policy, one for each training run. Each run is evaluated in all worlds.
    options : dict
        Arguments of the environment that differ for this agent, such as `action`.
    curve : str
        `config` of a policy's learning curves.
    """

    title: str
    kind: Literal["oracle", "adaptive", "policy"]
    settings: dict[str, Any] = field(default_factory=dict)
    files: list[str] = field(default_factory=list)
    options: dict[str, Any] = field(default_factory=dict)
    curve: str = ""

    @property
    def identity(self) -> dict[str, Any]:
        """Everything except the policy's file that an episode depends on."""
        return {"kind": self.kind, "settings": self.settings, "options": self.options}

    @property
    def learns(self) -> bool:
        """Whether the agent adapts during an episode."""
        return self.kind == "adaptive" and bool(self.settings.get("adapt", True))

    @property
    def runs(self) -> range:
        """Run numbers: one for each file of a policy."""
        return range(len(self.files) or 1)


@dataclass(frozen=True)
class Target:
    """Target of a figure of an agent in a group of worlds: `least` or `most`."""

    worlds: str
    agent: str
    figure: Literal["success", "quick success", "regret"]
    least: float | None = None
    most: float | None = None


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
    """

    name: str
    title: str
    worlds: dict[str, Worlds]
    agents: dict[str, Agent]
    main: str
    push: float = 0.5
    pairs: list[tuple[str, str]] = field(default_factory=list)
    targets: list[Target] = field(default_factory=list)


def read(path: Path) -> Settings:
    """Read the file of a comparison.

    Raises
    ------
    TrundleError
        If a key is missing, unknown or of another type, or a name is not defined.
    """
    settings = build_settings(path, Settings, parse_format(path, FORMAT))
    check_settings(path, settings)
    return settings


def check_settings(path: Path, settings: Settings) -> None:
    """Raise an error if the settings are inconsistent."""
    if not settings.push > 0 or not re.fullmatch(r"[\w-]+", settings.name):
        raise TrundleError(
            f"{path}: push = {settings.push}, name = {settings.name!r}: give a positive duration, "
            "and a name of letters, digits, _ or -"
        )
    if not settings.worlds:
        raise TrundleError(f"{path}: give at least one table [worlds.NAME]")
    check_agents(path, settings, "main", [settings.main])
    for name, agent in settings.agents.items():
        check_agent(f"{path}: [agents.{name}]", agent)
        check_horizon(path, agent.options, f"agents.{name}")
        check_argument_types(path, AdaptiveAgent.__init__, agent.settings, f"agents.{name}.settings")
    for name, worlds in settings.worlds.items():
        check_agents(path, settings, f"[worlds.{name}] agents", worlds.agents)
        if worlds.count < 1 or worlds.first < 0:
            raise TrundleError(f"{path}: [worlds.{name}]: give first >= 0 and count >= 1")
        check_horizon(path, worlds.options, f"worlds.{name}")
    for pair in settings.pairs:
        check_agents(path, settings, "pairs", list(pair))
    for target in settings.targets:
        check_target(path, settings, target)


def check_agents(path: Path, settings: Settings, where: str, names: list[str]) -> None:
    """Raise an error for names that are not agents."""
    for name in names:
        if name not in list(settings.agents):
            known = ", ".join(settings.agents)
            raise TrundleError(f"{path}: {where}: unknown agent {name!r}; choose from {known}")


def check_agent(where: str, agent: Agent) -> None:
    """Raise an error for keys that do not apply to an agent's kind."""
    if (agent.kind == "policy") != bool(agent.files):
        raise TrundleError(f"{where} files: required for a policy, not allowed for other agents")
    if agent.kind == "policy" and agent.settings:
        raise TrundleError(
            f"{where} settings: not allowed for a policy; they are arguments of trundle.AdaptiveAgent"
        )
    if "model" in agent.settings:
        raise TrundleError(f'{where} settings: model is not allowed; kind = "oracle" uses the hidden model')


def check_target(path: Path, settings: Settings, target: Target) -> None:
    """Raise an error if a target refers to unknown worlds or agents, or does not have exactly one bound."""
    check_agents(path, settings, "targets", [target.agent])
    if target.worlds not in settings.worlds:
        known = ", ".join(settings.worlds)
        raise TrundleError(f"{path}: targets: unknown worlds {target.worlds!r}; choose from {known}")
    if (target.least is None) == (target.most is None):
        raise TrundleError(f"{path}: targets: {target}: give least or most")
