"""What is to be run: a TOML file whose keys are all known."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import gymnasium as gym

import trundle
from trundle.recording import TrundleError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["Settings", "read"]

FORMAT = "trundle-run/1"
TABLES = ("none", "csv", "parquet")
KINDS: dict[str, tuple[Any, str]] = {
    "environment": (str, "a text"),
    "seed": (int, "a whole number"),
    "episodes": (int, "a whole number"),
    "recording": (str, "a text"),
    "arguments": (dict, "a table"),
    "agent": (dict, "a table"),
}


@dataclass(frozen=True)
class Settings:
    """What a run depends on.

    Attributes
    ----------
    environment : str
        Gymnasium's id of a pushing task.
    seed : int
        Of the first episode; the next have the numbers that follow.
    episodes : int
        How many; each draws everything anew, and the agent begins it knowing nothing.
    recording : str
        Table of the recordings, "csv" or "parquet"; "none" keeps none.
    arguments : dict
        Of the environment.
    agent : dict
        Of `trundle.AdaptiveAgent`; `model` is the path of a file, seen from the configuration's folder.
    text : str
        The file.
    folder : Path
        Where it lies.
    """

    environment: str
    seed: int = 0
    episodes: int = 1
    recording: str = "csv"
    arguments: dict[str, Any] = field(default_factory=dict)
    agent: dict[str, Any] = field(default_factory=dict)
    text: str = ""
    folder: Path = Path()

    def begin(self, number: int) -> tuple[gym.Env[Any, Any], trundle.AdaptiveAgent]:
        """Return the environment and the agent of an episode; `play` begins it with `seed + number`."""
        env = self._environment()
        env.reset(seed=self.seed + number)  # before that, an agent could not ask which object there is
        model = None if self.model is None else trundle.Model.read(self.model)
        chosen = {name: value for name, value in self.agent.items() if name != "model"}
        try:
            return env, trundle.AdaptiveAgent(env, model=model, **chosen)
        except TypeError as error:
            raise TrundleError(f"[agent]: {error}") from None

    def _environment(self) -> gym.Env[Any, Any]:
        try:
            return gym.make(self.environment, **self.arguments)
        except TypeError as error:
            raise TrundleError(f"[arguments] of {self.environment}: {error}") from None

    @property
    def model(self) -> Path | None:
        """File of the agent's first belief; None for the default one."""
        return self.folder / self.agent["model"] if "model" in self.agent else None

    def plain(self) -> dict[str, Any]:
        """Return everything that the result depends on, as plain values."""
        kept = {name: getattr(self, name) for name in KINDS}
        model = None if self.model is None else trundle.Model.read(self.model).to_toml()
        return {**kept, "model": model, "version": trundle.__version__}


def read(path: Path) -> Settings:
    """Read a run's file.

    Raises
    ------
    TrundleError
        If a key is unknown, missing or of another type, or the environment or the agent refuses its own.
    """
    text = path.read_text(encoding="utf-8")
    try:
        found = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise TrundleError(f"{path}: {error}") from None
    if found.pop("format", None) != FORMAT:
        raise TrundleError(f'{path}: must begin with format = "{FORMAT}"')
    for name in found:
        check(path, name, found)
    if "environment" not in found:
        raise TrundleError(f"{path}: the key 'environment' is missing; give one of {', '.join(tasks())}")
    settings = Settings(**found, text=text, folder=path.parent)
    try:
        settings.begin(0)
    except TrundleError as error:
        raise TrundleError(f"{path}: {error}") from None
    return settings


def check(path: Path, name: str, found: Mapping[str, Any]) -> None:
    """Refuse a key that is unknown, and a value that cannot be meant."""
    if name not in KINDS:
        raise TrundleError(f"{path}: unknown key '{name}'; known are format, {', '.join(KINDS)}")
    value, (kind, words) = found[name], KINDS[name]
    if type(value) is not kind:
        raise TrundleError(f"{path}: {name} = {value!r} is not {words}")
    if name == "environment" and value not in tasks():
        raise TrundleError(f"{path}: environment = {value!r}: choose {', '.join(tasks())}")
    if name == "recording" and value not in TABLES:
        raise TrundleError(f"{path}: recording = {value!r}: choose {', '.join(TABLES)}")
    if name == "seed" and value < 0:
        raise TrundleError(f"{path}: seed = {value}: a seed is a whole number from 0 on")
    if name == "episodes" and value < 1:
        raise TrundleError(f"{path}: episodes = {value}: at least one")
    if name == "arguments" and value.get("horizon") == 0:
        raise TrundleError(f"{path}: [arguments] horizon = 0: an episode must end; give a number of steps")


def tasks() -> list[str]:
    """Return the environments that can be run: those whose observations are arrays."""
    return [f"trundle/{task.__name__}-v0" for task in trundle.envs.FLAT]
