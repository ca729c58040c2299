"""Read the file of a closed-loop run."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Literal

import gymnasium as gym

import trundle
from trundle.agent_settings import AgentSettings, read_agent_settings
from trundle.envs.ids import flat_ids
from trundle.recording import TrundleError
from trundle.settings import build_settings, check_horizon, parse_format

__all__ = ["Settings", "read"]

FORMAT = "trundle-run/1"


@dataclass(frozen=True)
class File:
    """Contents of a run's file.

    Attributes
    ----------
    environment : str
        Gymnasium's id of a pushing task.
    seed : int
        Of the first episode; the following episodes have the following seeds.
    episodes : int
        Number of episodes. Each starts with a new world and a new belief.
    recording : str
        Table format of the recordings, or "none".
    arguments : dict
        Of the environment.
    agent : dict
        Fields of `trundle.AgentSettings`, and `model`: path of the first model, relative to the file's
        folder.
    """

    environment: str
    seed: int = 0
    episodes: int = 1
    recording: Literal["csv", "parquet", "none"] = "csv"
    arguments: dict[str, Any] = field(default_factory=dict)
    agent: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Settings(File):
    """Settings of a run: its file's keys, its text, and its folder."""

    text: str = ""
    folder: Path = Path()

    @property
    def model(self) -> trundle.Model | None:
        """The agent's initial model; None for the default one."""
        return trundle.Model.read(self.folder / self.agent["model"]) if "model" in self.agent else None

    @property
    def agent_settings(self) -> AgentSettings:
        """The agent's settings."""
        return AgentSettings(**{key: value for key, value in self.agent.items() if key != "model"})

    def begin(self, number: int) -> tuple[gym.Env[Any, Any], trundle.AdaptiveAgent]:
        """Return the environment and the agent of an episode; `play` resets it with `seed + number`."""
        try:
            env = gym.make(self.environment, **self.arguments)
        except TypeError as error:
            raise TrundleError(f"[arguments] of {self.environment}: {error}") from None
        return env, trundle.AdaptiveAgent(env, self.agent_settings, model=self.model)

    def plain(self) -> dict[str, Any]:
        """Return everything that the result depends on, as plain values."""
        kept = {one.name: getattr(self, one.name) for one in fields(File)}
        model = None if self.model is None else self.model.to_toml()
        return {**kept, "model": model, "version": trundle.__version__}


def read(path: Path) -> Settings:
    """Read a run's file.

    Raises
    ------
    TrundleError
        If a key is unknown, missing or of another type, or the environment or the agent rejects its
        arguments.
    """
    file = build_settings(path, File, parse_format(path, FORMAT))
    supported = flat_ids()
    if file.environment not in supported:
        raise TrundleError(f"{path}: environment = {file.environment!r}: choose {', '.join(supported)}")
    if file.seed < 0:
        raise TrundleError(f"{path}: seed = {file.seed}: give an integer of at least 0")
    if file.episodes < 1:
        raise TrundleError(f"{path}: episodes = {file.episodes}: give at least one")
    check_horizon(path, file.arguments, "arguments")
    fields_of_agent = dict(file.agent)
    model = fields_of_agent.pop("model", "")
    if not isinstance(model, str):
        raise TrundleError(f"{path}: `agent.model` = {model!r}; it is a string")
    read_agent_settings(path, fields_of_agent, "agent")
    settings = Settings(**vars(file), text=path.read_text(encoding="utf-8"), folder=path.parent)
    # The agent decides once without rendering, so that errors appear before anything is written.
    env = None
    try:
        env, agent = replace(settings, arguments={**settings.arguments, "render_mode": None}).begin(0)
        agent.predict(env.reset(seed=settings.seed)[0], episode_start=True)
    except TrundleError as error:
        raise TrundleError(f"{path}: {error}") from None
    finally:
        if env is not None:
            env.close()
    return settings
