"""Discriminating experiments: the pushes for which two models predict the most different motion."""

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
"""Default standard deviations of position, heading, force and torque without a recording: m, rad, N, N·m."""


@dataclass(frozen=True)
class DesignedPush:
    """One push of a design.

    Attributes
    ----------
    grasp : tuple of two floats
        Grasp point, object frame, m.
    direction : float
        Direction of the push, object frame, rad.
    start : tuple of three floats
        Initial pose of the object at rest, world frame, m and rad.
    profile : str
        Shape of the wrench over time.
    force, torque, duration : float
        Maximum force, N, maximum torque, N·m, and time in contact, s.
    knots : array of shape (n, 4)
        The command: rows ``[t, f_x, f_y, τ]`` in s from contact, N and N·m, in gripper axes (x along
        ``direction``), interpolated linearly.
    separation : float
        Expected log-likelihood ratio of this push alone, nats, averaged over which model is true.
    cumulative : float
        The same for this push and all previous ones of the design.
    sentence : str
        Instruction in words.
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
        """Return the push as a ``[[push]]`` table of a scenario."""
        return {
            "start": list(self.start),
            "grasp": [*self.grasp, self.direction],
            "drive": "force",
            "knots": self.knots.tolist(),
        }


@dataclass(frozen=True)
class Design:
    """The pushes that best discriminate two models.

    Attributes
    ----------
    models : tuple of two str
        Names of the models: the effects that only this model has.
    pushes : tuple of DesignedPush
        The pushes; empty if no push within the limits discriminates the models.
    separation : tuple of two floats
        Expected log-likelihood ratio of all pushes against the best refit of the other model, nats: if the
        first model is true, and if the second is true.
    recorded : float
        Log evidence of the recording for the first model over the second, nats (0 without a recording).
    sure : float
        Probability that the true model has a posterior probability above 0.95 after the pushes.
    repeats : int or None
        Number of repetitions for which ``sure`` reaches 0.95; None if 50 are not enough.
    sentence : str
        Summary in words.
    fitted : tuple of two Model
        The models with all values; fitted if there is a recording.

    Examples
    --------
    >>> import trundle
    >>> found = trundle.design("a.toml", "b.toml", object="recordings/run_3")  # doctest: +SKIP
    >>> found.pushes[0].sentence  # doctest: +SKIP
    >>> scenario, object_file = found.scenario()  # doctest: +SKIP
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
        """Return the content of ``design.json``."""
        return json.dumps(self._answer, indent=2, ensure_ascii=False)

    def scenario(self, truth: Model | PathLike | None = None) -> tuple[str, str]:
        """Return the texts of a scenario with these pushes, and of its ``object.toml``.

        Parameters
        ----------
        truth : Model or path, optional
            True model of the scenario, with all values; by default the first of the two models.

        Raises
        ------
        TrundleError
            If the model has no footprint (as on a rail), contains an unnamed wrench, or there is no push.
        """
        model = tomllib.loads(model_text(self.fitted[0] if truth is None else truth) or "")
        body = model.get("body", {})
        if not {"footprint", "fixture"} & body.keys():
            raise TrundleError("the model has no footprint: `trundle simulate` needs one")
        if "unnamed" in model:
            raise TrundleError(
                "a scenario cannot contain an unnamed wrench: remove `[unnamed]` from the model"
            )
        if not self.pushes:
            raise TrundleError("there is no push to simulate: no push discriminates these models")
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
        """Write ``design.json``, and ``scenario.toml`` with ``object.toml`` if they can be simulated."""
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
    """Find the pushes that best discriminate two models.

    Each model is compared with the best refit of the other one; docs/design.md describes the method.

    Parameters
    ----------
    model_a, model_b : Model or path
        With a recording, both are fitted to it. Without one, all values must be given; their uncertainty is
        the posterior in the model file, or else the priors of the catalogue.
    recording : Recording or path, optional
        Recording of the object. It provides previous episodes, the noise and the instruments.
    object : path, optional
        An object or model file with a ``[body]``, for models that have no footprint.
    noise : tuple of four floats
        Standard deviations of position (m), heading (rad), force (N) and torque (N·m) without a recording.
    pushes : int
        Number of pushes; each is the best in addition to the previous ones.
    force, torque, duration, speed, spin, distance : float, optional
        Limits of a push (N, N·m, s) and of the motion of the object (m/s, rad/s, m). The defaults are those
        of the recording; without one they are 30, 8, 6, 0.6, 1, 1.2.
    progress : callable, optional
        Called with the stage of the work and the finished share of all work, 0 to 1, which never decreases.

    Returns
    -------
    Design

    Raises
    ------
    TrundleError
        If a model has no footprint or no value for a parameter, cannot be fitted, or a limit is not positive.

    Examples
    --------
    >>> import trundle
    >>> found = trundle.design("a.toml", "b.toml", object="recordings/run_3", count=2)  # doctest: +SKIP
    >>> print(found.sentence)  # doctest: +SKIP
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
    answer, first, second = _native._design(
        *texts,
        recording=None if recording is None else native_recording(recording),
        body=None if object is None else _body_toml(Path(object)),
        noise=noise,
        limits={name: float(value) for name, value in limits.items() if value is not None},
        count=pushes,
        progress=progress,
    )
    return _parse_design(answer, (first, second))


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
    """Return the text of a model file that contains only the body of an object or model file."""
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise TrundleError(f"{path}: {error}") from error
    if not isinstance(found.get("body"), dict):
        raise TrundleError(
            f"{path}: has no [body]; give an object file, a model file, or the folder of a recording"
        )
    return tomli_w.dumps({"format": "trundle-model/1", "body": found["body"]})


def _is_simulable(text: str) -> bool:
    """Return whether a scenario can contain a model: it has a footprint and no unnamed wrench."""
    model = tomllib.loads(text)
    return "unnamed" not in model and bool({"footprint", "fixture"} & model.get("body", {}).keys())
