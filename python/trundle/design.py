"""The push that tells two models apart."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import tomli_w
from numpy.typing import NDArray

from trundle import _native
from trundle._native import Model, Recording, TrundleError
from trundle.atomic import write_text
from trundle.diagnosis import PathLike, Progress, model_text, native_recording

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["Design", "DesignedPush", "design"]

Profile = Literal["steady", "there_and_back", "shuttle", "pulses", "two_frequencies", "turn", "weave"]

DEFAULT_NOISE_SD = (0.0005, 0.00175, 0.4, 0.05)
"""Standard deviations where no recording says more: m, rad, N, N·m."""


@dataclass(frozen=True)
class DesignedPush:
    """One push of a design.

    Attributes
    ----------
    grasp : tuple of two floats
        Where the gripper holds the object, object frame, m.
    direction : float
        Along which it pushes, object frame, rad.
    start : tuple of three floats
        Pose at which the object stands at rest first, world, m and rad.
    profile : str
        Course of the wrench.
    force, torque, duration : float
        Largest force, N, largest torque, N·m, and time in contact, s.
    knots : array of shape (n, 4)
        The command: rows ``[t, f_x, f_y, τ]``, s from contact on, N, N·m, gripper axes (x along
        ``direction``), straight lines between.
    separation : float
        Expected log-likelihood ratio by this push alone, nats, mean over which model is true.
    cumulative : float
        The same with all pushes of the design up to this one.
    sentence : str
        What to do.
    """

    grasp: tuple[float, float]
    direction: float
    start: tuple[float, float, float]
    profile: Profile
    force: float
    torque: float
    duration: float
    knots: NDArray[np.float64]
    separation: float
    cumulative: float
    sentence: str

    def table(self) -> dict[str, Any]:
        """Return the push as a ``[[push]]`` of a scenario."""
        return {
            "start": list(self.start),
            "grasp": [*self.grasp, self.direction],
            "drive": "force",
            "knots": self.knots.tolist(),
        }


@dataclass(frozen=True)
class Design:
    """The pushes that best tell two models apart.

    Attributes
    ----------
    models : tuple of two str
        What the models are called: the effects that one has and the other has not.
    pushes : tuple of DesignedPush
        What to do; empty where no push within the limits tells anything.
    separation : tuple of two floats
        Expected log-likelihood ratio of all pushes against the best refit of the other model, nats: if the
        first is true, and if the second is.
    recorded : float
        By how much the recording already prefers the first, nats (0 without one).
    sure : float
        Chance that the true model has a probability above 0.95 afterwards.
    repeats : int or None
        How often the pushes must be made for that chance to be 0.95; None where 50 times do not suffice.
    sentence : str
        All of it for a person.
    fitted : tuple of two Model
        The models at their values: fitted, if there is a recording.
    """

    models: tuple[str, str]
    pushes: tuple[DesignedPush, ...]
    separation: tuple[float, float]
    recorded: float
    sure: float
    repeats: int | None
    sentence: str
    fitted: tuple[Model, Model]
    _answer: dict[str, Any]

    def to_json(self) -> str:
        """Return the whole for programs (``design.json``)."""
        return json.dumps(self._answer, indent=2, ensure_ascii=False)

    def scenario(self, truth: Model | PathLike | None = None) -> tuple[str, str]:
        """Return the texts of a scenario with these pushes, and of its ``object.toml``.

        Parameters
        ----------
        truth : Model or path, optional
            What is hidden in it, all values given; the first of the two models, as fitted, if not given.

        Raises
        ------
        TrundleError
            If the model has no footprint (an object on a rail cannot be simulated), holds an unnamed wrench
            (a scenario cannot), or there is no push.
        """
        model = tomllib.loads(model_text(self.fitted[0] if truth is None else truth) or "")
        body = model.get("body", {})
        if not {"footprint", "fixture"} & body.keys():
            raise TrundleError("the model has no footprint: `trundle simulate` needs one")
        if "unnamed" in model:
            raise TrundleError("a scenario cannot hold an unnamed wrench: leave `[unnamed]` out")
        if not self.pushes:
            raise TrundleError("there is no push to simulate: none tells these models apart")
        named = {"format": "trundle-object/1", "name": "object", "body": body}
        tables = {
            "format": "trundle-scenario/1",
            "name": f"{self.models[0]} or {self.models[1]}",
            "object": "object.toml",
            "effect": model.get("effect", []),
            "push": [push.table() for push in self.pushes],
        }
        return tomli_w.dumps(tables), tomli_w.dumps(named)

    def write(self, folder: PathLike) -> Path:
        """Write ``design.json``, and ``scenario.toml`` with ``object.toml`` where they can be simulated."""
        folder = Path(folder)
        texts = {"design.json": self.to_json() + "\n"}
        if self.pushes and _is_simulable(self.fitted[0].to_toml()):
            texts["scenario.toml"], texts["object.toml"] = self.scenario()
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            write_text(folder / name, text)
        return folder


def design(
    model_a: Model | PathLike,
    model_b: Model | PathLike,
    *,
    recording: Recording | PathLike | None = None,
    object: PathLike | None = None,
    noise: tuple[float, float, float, float] = DEFAULT_NOISE_SD,
    pushes: int = 1,
    force: float | None = None,
    torque: float | None = None,
    duration: float | None = None,
    speed: float | None = None,
    spin: float | None = None,
    distance: float | None = None,
    progress: Progress | None = None,
) -> Design:
    """Find the pushes that tell two models apart best, whatever either could absorb (docs/design.md).

    Parameters
    ----------
    model_a, model_b : Model or path
        With a recording both are fitted to it. Without one all values must be given; each model then goes as
        far from them as its posterior says, or as the catalogue's priors do where it has none.
    recording : Recording or path, optional
        What was recorded of the object: its episodes count, and its instruments are used.
    object : path, optional
        A file with a ``[body]``, an object or a model, for models that have no footprint.
    noise : tuple of four floats
        Standard deviations of position (m), heading (rad), force (N) and torque (N·m), where no recording
        says more.
    pushes : int
        How many, each the best on top of those before.
    force, torque, duration, speed, spin, distance : float, optional
        Limits of a push: N, N·m, s; and of the object's motion: m/s, rad/s, m. What the recording shows if
        not given; without one 30, 8, 6; 0.6, 1, 1.2.
    progress : callable, optional
        Called with the stage of the work and the share of the whole that is done, 0 to 1; neither goes back.

    Returns
    -------
    Design

    Raises
    ------
    TrundleError
        If a model lacks a value or a footprint, cannot be fitted, or a limit is not positive.
    """
    if pushes < 1:
        raise TrundleError(f"pushes = {pushes}: at least one is needed")
    limits = {
        "force": force,
        "torque": torque,
        "duration": duration,
        "speed": speed,
        "spin": spin,
        "distance": distance,
    }
    texts = [model_text(model) or "" for model in (model_a, model_b)]
    answer, *fitted = _native._design(
        *texts,
        recording=None if recording is None else native_recording(recording),
        body=None if object is None else _body_toml(Path(object)),
        noise=noise,
        limits={name: float(value) for name, value in limits.items() if value is not None},
        count=pushes,
        progress=progress,
    )
    first, second = map(Model.from_toml, fitted)
    return _parse_design(json.loads(answer), (first, second))


def _parse_design(answer: dict[str, Any], fitted: tuple[Model, Model]) -> Design:
    def one(push: dict[str, Any]) -> DesignedPush:
        tuples = {"grasp": tuple(push["grasp"]), "start": tuple(push["start"])}
        return DesignedPush(**{**push, **tuples, "knots": np.asarray(push["knots"], dtype=float)})

    return Design(
        models=(answer["models"][0], answer["models"][1]),
        pushes=tuple(one(push) for push in answer["pushes"]),
        separation=(answer["separation"][0], answer["separation"][1]),
        recorded=answer["recorded"],
        sure=answer["sure"],
        repeats=answer["repeats"],
        sentence=answer["sentence"],
        fitted=fitted,
        _answer=answer,
    )


def _body_toml(path: Path) -> str:
    """Return a model file's text with nothing but the body of an object's or a model's file."""
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise TrundleError(f"{path}: {error}") from error
    if not isinstance(found.get("body"), dict):
        raise TrundleError(
            f"{path}: has no [body]; give an object's file, a model's, or a recording's folder"
        )
    return tomli_w.dumps({"format": "trundle-model/1", "body": found["body"]})


def _is_simulable(text: str) -> bool:
    """Tell whether a scenario can hold a model: it has a shape, and no wrench without a name."""
    model = tomllib.loads(text)
    return "unnamed" not in model and bool({"footprint", "fixture"} & model.get("body", {}).keys())
