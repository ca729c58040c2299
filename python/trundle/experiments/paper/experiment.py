"""Interface of the paper's experiments, their settings, and the objects that they push."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import tomli_w

from trundle.experiments.results import Row
from trundle.model import Model
from trundle.recording import TrundleError
from trundle.rules import Count
from trundle.settings import build_settings, parse, parse_format

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "Experiment",
    "Settings",
    "TaskObject",
    "build_model",
    "parse_settings",
    "product",
    "read",
    "title",
]

FORMAT = "trundle-paper/1"
WHEEL = "viscous_wheel"


@dataclass(frozen=True)
class TaskObject:
    """An object of `configs/objects` in one of its configurations.

    Attributes
    ----------
    name : str
    body : dict
        Table `[body]` of its file.
    effect : list of dict
        Effects of the configuration.
    radius : float, optional
        Radius of the largest circle in the footprint about the mass centre, m.
    """

    name: str
    body: dict[str, Any]
    effect: list[dict[str, Any]] = field(default_factory=list)
    radius: float | None = None

    def true_model(self) -> Model:
        """Return the true model."""
        return build_model(self.body, self.effect)

    def free_model(self, *kinds: str) -> Model:
        """Return a model of the object's shape whose mass and effects, by default one wheel, are free."""
        body = {key: value for key, value in self.body.items() if key != "mass"}
        return build_model(body, [{"kind": kind} for kind in kinds or (WHEEL,)])


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Settings of every experiment. Subclasses add the other keys of the experiment's file.

    Attributes
    ----------
    seeds : int
        Number of seeds.
    objects : list of str
        Files in `configs/objects` without `.toml`, or `file:configuration`.
    task_objects : dict
        The objects by these names.
    quick : bool
        Whether the table `[quick]` of the file replaces other keys.
    """

    seeds: Count
    objects: list[str]
    task_objects: dict[str, TaskObject] = field(default_factory=dict)
    quick: bool = False

    def plain(self) -> dict[str, Any]:
        """Return the settings as JSON values."""
        found: dict[str, Any] = json.loads(json.dumps(asdict(self)))
        return found


class Experiment(Protocol):
    """Members of an experiment's module, which has the name of the experiment's file in `configs`."""

    __name__: str
    Settings: type[Any]

    def trials(self, settings: Any) -> Sequence[Row]:
        """Return the names of all trials, in order."""

    def perform(self, settings: Any, trial: Row) -> Row:
        """Run one trial and return its results, plain values."""

    def values(self, settings: Any, rows: Sequence[Row]) -> dict[str, object]:
        """Return the values of the experiment's text in `prose/`; a row is a trial and its results."""

    def draw(self, settings: Any, rows: Sequence[Row]) -> Figure:
        """Return the experiment's figure."""


S = TypeVar("S", bound=Settings)


def read(kind: type[S], name: str, configs: Path, *, quick: bool = False, seeds: int | None = None) -> S:
    """Read the settings of an experiment and its objects.

    Parameters
    ----------
    kind : type
        The experiment's `Settings`.
    name : str
        Name of the experiment's file, without `.toml`.
    configs : Path
        Folder of `experiments/` and `objects/`.
    quick : bool
        Select the small version of the experiment.
    seeds : int, optional
        Number of seeds instead of that in the file.

    Raises
    ------
    TrundleError
        If a key is missing, unknown or of another type, or a value is not allowed.
    """
    path = configs / "experiments" / f"{name}.toml"
    found = parse_format(path, FORMAT, "; give its folder with --configs")
    changes = found.pop("quick", {})
    full, small = build_settings(path, kind, found), build_settings(path, kind, {**found, **changes})
    settings = small if quick else full
    task_objects = {one: read_object(configs / "objects", one) for one in settings.objects}
    return replace(settings, task_objects=task_objects, quick=quick, seeds=seeds or settings.seeds)


def parse_settings(path: Path, kind: type[S], stored: Row) -> S:
    """Return the settings in a file of results. Earlier files have the objects under other keys."""
    found = {key: value for key, value in stored.items() if key != "file"}
    if "object" in found:
        found["objects"] = [found.pop("object")]
        found["things"] = {found["objects"][0]: found.pop("thing")}
    if "cases" in found:
        found["objects"] = found.pop("cases")
    if "bodies" in found:
        found["things"] = {name: {"name": name, "body": body} for name, body in found.pop("bodies").items()}
    if "things" in found:
        found["task_objects"] = found.pop("things")
    return build_settings(path, kind, found)


def product(**levels: Iterable[Any]) -> list[Row]:
    """Return every combination of the levels of some factors; the last factor varies first."""
    return [dict(zip(levels, each, strict=True)) for each in itertools.product(*levels.values())]


def read_object(folder: Path, name: str) -> TaskObject:
    """Return an object, given as `file` or `file:configuration`; the default is the first configuration."""
    file, _, wanted = name.partition(":")
    path = folder / f"{file}.toml"
    found = parse(path)
    configurations = {one["name"]: one.get("effect", []) for one in found.get("configuration", [])}
    if wanted and wanted not in configurations:
        raise TrundleError(f"{path}: has no configuration '{wanted}'; it has {', '.join(configurations)}")
    effects = configurations.get(wanted or next(iter(configurations), ""), [])
    return TaskObject(found["name"], found["body"], effects, found.get("radius"))


def build_model(body: dict[str, Any], effects: list[dict[str, Any]]) -> Model:
    """Return the model of the tables of a `model.toml`."""
    return Model.from_toml(tomli_w.dumps({"format": "trundle-model/1", "body": body, "effect": effects}))


def title(name: str) -> str:
    """Return an object's name for a table: `office table, locked` for `office_table:locked`."""
    return name.replace("_", " ").replace(":", ", ")
