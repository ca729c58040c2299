"""Discriminating experiments: the pushes for which two models predict the most different motion."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import tomli_w
from numpy.typing import NDArray

from trundle import _native
from trundle._native import Model, Recording, TrundleError
from trundle.atomic import write_text
from trundle.display import Card, Displayed, Table
from trundle.fitting import Fit, fit
from trundle.native_inputs import PathLike, native_recording, read_model
from trundle.progress import ProgressOption, report_progress

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["DEFAULT_NOISE_SD", "Design", "DesignedPush", "design_pushes"]

Profile = Literal["steady", "there_and_back", "shuttle", "pulses", "two_frequencies", "turn", "weave"]

DEFAULT_NOISE_SD = (0.0005, 0.00175, 0.4, 0.05)
"""Default standard deviations of position, heading, force and torque without a recording: m, rad, N, N·m."""


@dataclass(frozen=True, repr=False)
class DesignedPush(Displayed):
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

    def _card(self) -> Card:
        facts = [
            ("grasp", f"({self.grasp[0]:.3g}, {self.grasp[1]:.3g}) m, direction {self.direction:.3g} rad"),
            ("limits", f"{self.force:.3g} N, {self.torque:.3g} N·m, {self.duration:.3g} s"),
            ("separation", f"{self.separation:.3g} nats, {self.cumulative:.3g} with the previous pushes"),
            ("push", self.sentence),
        ]
        return Card(f"trundle.DesignedPush: {self.profile}", facts)


@dataclass(frozen=True, repr=False)
class Design(Displayed):
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
    warnings : tuple of str
        A sentence with the residuals if neither model explains the recording. The design assumes that one of
        them is true.

    Examples
    --------
    >>> design = trundle.design("model.toml", "wheel.toml", force=60.0, duration=2.0)
    >>> design.pushes[0].separation > 10.0  # nats
    True
    """

    models: tuple[str, str]
    pushes: tuple[DesignedPush, ...]
    separation: tuple[float, float]
    recorded: float
    sure: float
    repeats: int | None
    sentence: str
    fitted: tuple[Model, Model]
    warnings: tuple[str, ...]
    _answer: dict[str, Any]

    def _card(self) -> Card:
        rows = [
            (str(number), push.profile, f"{push.separation:.3g}", f"{push.cumulative:.3g}", push.sentence)
            for number, push in enumerate(self.pushes, 1)
        ]
        facts = [
            ("models", " or ".join(self.models)),
            ("result", self.sentence),
        ]
        heads = ("push", "profile", "nats", "in total", "instruction")
        return Card(f"trundle.Design: {len(self.pushes)} pushes", facts, Table(heads, rows))

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
        model = tomllib.loads(read_model(self.fitted[0] if truth is None else truth).to_toml())
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


def design_pushes(
    model_a: Model | PathLike,
    model_b: Model | PathLike,
    *,
    recording: Recording | PathLike | None,
    object: PathLike | None,
    noise: tuple[float, float, float, float],
    pushes: int,
    limits: Mapping[str, float | None],
    progress: ProgressOption,
) -> Design:
    """Find the pushes that best discriminate two models; `trundle.design` describes the arguments."""
    if pushes < 1:
        raise TrundleError(f"pushes = {pushes}: at least one is needed")
    with report_progress(progress, "design") as report:
        answer, first, second = _native._design(
            read_model(model_a),
            read_model(model_b),
            recording=None if recording is None else native_recording(recording),
            body=None if object is None else _read_body(Path(object)),
            noise=noise,
            limits={name: float(value) for name, value in limits.items() if value is not None},
            count=pushes,
            progress=report,
        )
    if recording is not None:
        answer["warnings"] = _check_fits(recording, answer["models"], (first, second))
    return _parse_design(answer, (first, second))


def _check_fits(
    recording: Recording | PathLike, names: tuple[str, str], fitted: tuple[Model, Model]
) -> list[str]:
    """Return a warning if neither model explains the recording."""
    found = []
    for name, model in zip(names, fitted, strict=True):
        lack = _refit(recording, model).summary["lack_of_fit"]
        if lack is None or not lack["found"]:
            return []
        force, torque = lack["residual_force_rms"], lack["residual_torque_rms"]
        found.append(f"with {name}, {force:.3g} N and {torque:.3g} N·m rms remain")
    return [
        f"neither model explains the recording ({'; '.join(found)}), but the design assumes that one of them "
        "is true: run `trundle diagnose` on the recording first"
    ]


def _refit(recording: Recording | PathLike, fitted: Model) -> Fit:
    """Fit a model from its values, which is one short search with a lack-of-fit test."""
    free = _without_values(fitted)
    values = {parameter["name"]: parameter["value"] for parameter in fitted.parameters}
    start = {p["name"]: values[p["name"]] for p in free.parameters if p["value"] is None}
    try:
        return fit(recording, free, start=start, starts=0, progress=False)
    except TrundleError:
        # A recording that gives a value, such as the mass, leaves other parameters free.
        return fit(recording, free, starts=2, progress=False)


def _without_values(model: Model) -> Model:
    """Return a model whose parameters are free, except those with a default in the catalogue."""
    tables = tomllib.loads(model.to_toml())
    named = {effect["kind"]: {p["name"] for p in effect["parameters"]} for effect in _native.effects()}
    mass = {p["name"].removeprefix("body.") for p in model.parameters if p["name"].startswith("body.")}
    kept = {
        "format": tables["format"],
        "body": {key: value for key, value in tables.get("body", {}).items() if key not in mass},
        "effect": [
            {key: value for key, value in effect.items() if key not in named[effect["kind"]]}
            for effect in tables.get("effect", [])
        ],
    }
    return Model.from_toml(tomli_w.dumps(kept))


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
        warnings=tuple(answer.get("warnings", ())),
        _answer=answer,
    )


def _read_body(path: Path) -> Model:
    """Return a model that contains only the body of an object or model file."""
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise TrundleError(f"{path}: {error}") from error
    if not isinstance(found.get("body"), dict):
        raise TrundleError(
            f"{path}: has no [body]; give an object file, a model file, or the folder of a recording"
        )
    return Model.from_toml(tomli_w.dumps({"format": "trundle-model/1", "body": found["body"]}))


def _is_simulable(text: str) -> bool:
    """Return whether a scenario can contain a model: it has a footprint and no unnamed wrench."""
    model = tomllib.loads(text)
    return "unnamed" not in model and bool({"footprint", "fixture"} & model.get("body", {}).keys())
