"""Fit, predict, diagnose: what a recording says about a model."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

from trundle import _native
from trundle._native import Model, Recording, TrundleError
from trundle.atomic import atomic_file, atomic_folder
from trundle.black_box import Parameters, Step, parse_parameters
from trundle.input_checks import require_usable
from trundle.report import inputs, render

__all__ = ["Diagnosis", "Fit", "diagnose", "fit", "predict"]

PathLike: TypeAlias = "str | os.PathLike[str]"
Progress: TypeAlias = Callable[[str, float], object]
Likelihood: TypeAlias = Literal["filter", "steps", "final", "windows", "wrench"]


@dataclass(frozen=True)
class Fit:
    """A model fitted to a recording.

    Attributes
    ----------
    model : Model
        The model with every value filled in, and its posterior.
    summary : dict
        ``parameters`` (a list of name, mean, sd, low, high, unit, identifiable; low and high are the ends of
        the 90 % interval; a parameter that is not identifiable has no number), ``log_evidence``,
        ``converged``, ``quasi_static``, ``noise``, ``lack_of_fit`` (found, gain_nats, residual_force_rms,
        residual_torque_rms; None where it is not tested), ``intervals`` (basis "curvature" or "sandwich",
        and the number of episodes of the latter),
        ``identifiability`` (directions and combinations that the data hold, and how many starts agree; left
        out where a caller's prior excludes the data), and the figures of ``training`` and ``held_out``
        episodes (SI units; None where a figure makes no sense).
    """

    model: Model
    summary: dict[str, Any]

    @property
    def explains_data(self) -> bool | None:
        """Whether the lack-of-fit test passes; None where there is no test.

        The test is for the default likelihood of motion, with parameters shared by all episodes. Where the
        model does not explain the data, `trundle.diagnose` looks for the missing effect.
        """
        lack = self.summary["lack_of_fit"]
        return None if lack is None else not lack["found"]

    @property
    def residual_force_rms(self) -> float | None:
        """Root mean square of the force that the model does not explain, N; None where there is no test."""
        lack = self.summary["lack_of_fit"]
        return None if lack is None else float(lack["residual_force_rms"])


@dataclass(frozen=True)
class Diagnosis:
    """What a diagnosis found.

    Attributes
    ----------
    answer : dict
        The content of ``diagnosis.json`` (``trundle-diagnosis/1``).
    model : Model
        The extended model, fitted.
    report : str
        ``report.html``: one page without scripts or links.
    series : dict
        The curves behind the report, by episode: poses observed and simulated, and wrenches recorded and
        needed (``wrench``: ``t``, ``recorded``, ``before``, ``after``) where those are compared; SI units.
    """

    answer: dict[str, Any]
    model: Model
    report: str
    series: dict[str, Any]
    _outcome: _native._Outcome

    @property
    def verdict(self) -> str:
        """Say "consistent", "reparameterised", "explained" or "unexplained"."""
        return str(self.answer["verdict"])

    @property
    def missing(self) -> list[str]:
        """Names of the effects that were left out, largest contribution first."""
        return [str(effect["effect"]) for effect in self.answer["missing"]]

    def write(self, folder: PathLike) -> Path:
        """Write ``diagnosis.json``, ``report.html``, ``model.toml`` and ``predictions.parquet``.

        Parameters
        ----------
        folder : path
            Made or replaced; it appears whole or not at all.

        Raises
        ------
        TrundleError
            If the folder holds anything but an earlier diagnosis.
        """
        with atomic_folder(Path(folder), ANSWER_FILE, "a diagnosis") as partial:
            (partial / ANSWER_FILE).write_text(self._outcome.answer + "\n", encoding="utf-8")
            (partial / "report.html").write_text(self.report, encoding="utf-8")
            (partial / "model.toml").write_text(self._outcome.model, encoding="utf-8")
            self._outcome.write_predictions(partial / "predictions.parquet")
        return Path(folder)


ANSWER_FILE = "diagnosis.json"


def fit(
    recording: Recording | PathLike | Sequence[Recording | PathLike],
    model: Model | PathLike | None = None,
    *,
    likelihood: Likelihood | None = None,
    window: float = 1.0,
    loss: Literal["gaussian", "student"] = "gaussian",
    per_episode: Sequence[str] = (),
    obstacles: bool | None = None,
    step: Step | None = None,
    prior: PathLike | None = None,
    start: Mapping[str, float] | None = None,
    starts: int = 6,
    seed: int = 0,
    optimiser: Literal["lm", "lbfgs"] = "lm",
    progress: Progress | None = None,
) -> Fit:
    """Fit a model's free values to the training episodes of one or several recordings of an object.

    The maximum a posteriori estimate under one of several likelihoods (docs/estimation.md). By default that
    of the poses given the recorded wrench, whose noise and tare error drive the motion (eq. 5-6 of the paper,
    by prediction errors); for quasi-static pushes that of the wrench that the motion needs.

    Parameters
    ----------
    recording : Recording or path, or a sequence of them
        Several must be of the same object; each keeps its own noise, frames and rates.
    model : Model or path, optional
        Values that it leaves out are free; the paper's model (eq. 3) if not given.
    likelihood : {"filter", "steps", "final", "windows", "wrench"}, optional
        What is compared: the default above; displacements step by step (eq. 8); the last pose of each episode
        (eq. 9); poses over windows; the wrench that the motion needs, inertia included. Left out, it is
        "filter", but "windows" where the object can touch a known obstacle or ``step`` is given.
    window : float
        Length of a window, s.
    loss : {"gaussian", "student"}
        Distribution of residuals; Student's t has four degrees of freedom.
    per_episode : sequence of str
        Names of parameters that each episode has its own of.
    obstacles : bool, optional
        False: obstacles that the recording names are not taken into account.
    step : callable, optional
        Your own simulator, in the place of the laws: ``step(state, wrench, dt, values)`` returns the state
        after ``dt`` seconds. States are pose and twist ``[x, y, theta, vx, vy, omega]`` in the world; the
        wrench ``[fx, fy, tau]`` is in the object's axes about its origin; ``values`` has every parameter by
        name. Called for one rollout at a time, hundreds of thousands of times.
    prior : path, optional
        A prior file: what is believed of free parameters where it is not what the catalogue says
        (docs/estimation.md).
    start : mapping of str to float, optional
        A value for every free parameter, by the names of the summary: searched from there as well, and with
        ``starts=0`` from there alone.
    starts : int
        Random starts.
    seed : int
        The same input and seed give the same bytes.
    optimiser : {"lm", "lbfgs"}
        Levenberg–Marquardt, or L-BFGS as in the paper: the same optimum in more time.
    progress : callable, optional
        Called with the stage of the work and the share of the whole that is done, 0 to 1; neither goes back.

    Returns
    -------
    Fit

    Raises
    ------
    TrundleError
        If there is not enough data, the model does not fit the object, the recordings contradict each other,
        or a prior cannot be used. What ``step`` raises is raised as it is.
    """
    if starts < (1 if start is None else 0):
        raise TrundleError(f"starts = {starts}: at least one start is needed")
    beliefs = None if prior is None else (str(prior), Path(prior).read_text(encoding="utf-8"))
    summary, text = _native._fit(
        native_recordings(recording),
        model_text(model),
        choice={
            "likelihood": likelihood,
            "window": window,
            "loss": loss,
            "obstacles": obstacles,
            "step": step,
        },
        per_episode=list(per_episode),
        prior=beliefs,
        start=start,
        starts=starts,
        seed=seed,
        optimiser=optimiser,
        progress=progress,
    )
    return Fit(Model.from_toml(text), json.loads(summary))


def predict(recording: Recording | PathLike, model: Model | PathLike, out: PathLike) -> Path:
    """Simulate every episode in open loop and write the poses beside the recorded ones.

    Parameters
    ----------
    recording : Recording or path
    model : Model or path
        With all values given.
    out : path
        A Parquet file with ``episode``, ``t`` (s), ``observed_x``, ``observed_y`` (m), ``observed_theta``
        (rad) and the same ``predicted_*``, one row for each pose sample; it appears whole or not at all.

    Raises
    ------
    TrundleError
        If a value of the model is free.
    """
    target = Path(out)
    with atomic_file(target) as part:
        _native._predict(native_recording(recording), model_text(model) or "", part)
    return target


def diagnose(
    recording: Recording | PathLike,
    model: Model | PathLike | None = None,
    *,
    step: Step | None = None,
    parameters: Parameters | None = None,
    seed: int = 0,
    without: Sequence[str] = (),
    wrench_pose: Literal["own_time", "latest"] = "own_time",
    check: bool = True,
    progress: Progress | None = None,
    command: str | None = None,
) -> Diagnosis:
    """Find where a simulation and a recording differ, and say what physics was left out.

    Parameters
    ----------
    recording : Recording or path
    model : Model or path, optional
        The simulation under test: its laws, and its values if it gives any. The paper's if not given.
    step : callable, optional
        Your own simulator in the place of a model: ``step(state, wrench, dt, values)`` returns the state
        after ``dt`` seconds. States are pose and twist ``[x, y, theta, vx, vy, omega]`` of the object frame's
        origin in the world; the wrench ``[fx, fy, tau]`` is in the object's axes about its origin, and what a
        law that was left out would add is added to it; ``values`` has every parameter by name. It must answer
        the same to the same question. docs/your-simulator.md tells more.
    parameters : mapping, optional
        Of that simulator, by name: a number (positive; hardly anything is believed of it), ``(start, lower,
        upper)``, or a dict with ``start`` and any of ``lower``, ``upper``, ``sd`` and ``unit``. Where all are
        numbers they are the values that the simulation is used with, and tested as well.
    seed : int
        The same input and seed give the same bytes.
    without : sequence of str, optional
        Names of effects that are not to be tried, as in ``trundle effects``.
    wrench_pose : {"own_time", "latest"}
        The pose that brings each wrench to the object: the smoothed one at the wrench's own time, or the
        latest recorded one (equation 13 of the paper).
    check : bool
        Refuse a recording whose units, sign, axes or clocks are surely wrong (see `trundle.check`). False for
        objects so large, small, fast or slow that their numbers look like other units.
    progress : callable, optional
        Called with the stage of the work and the share of the whole that is done, 0 to 1; neither goes back.
    command : str, optional
        Shown in the report as the way to reproduce it.

    Returns
    -------
    Diagnosis

    Raises
    ------
    TrundleError
        If units, sign, axes or clocks of the recording are surely wrong (see `trundle.check`), if there is
        not enough data, or the model does not fit the object; with ``step``, if that raises an
        exception or returns anything but six finite numbers: the message names the episode, the time, the
        state and the values, and the exception is the cause.
    """
    doubts = require_usable(recording) if check else []
    if step is not None:
        if model is not None or without:
            raise TrundleError("step: it is the simulation under test; leave out `model` and `without`")
        described_parameters, given = parse_parameters(parameters)
        outcome = _native._diagnose_foreign(
            native_recording(recording), step, described_parameters, given=given, seed=seed, progress=progress
        )
        command = command or f"trundle.diagnose(..., step=..., seed={seed})"
        return build_diagnosis(recording, outcome, seed, command, model, doubts)
    if parameters is not None:
        raise TrundleError("parameters: they are those of `step`; a model says its own")
    outcome = _native._diagnose(
        native_recording(recording),
        model_text(model),
        seed=seed,
        without=check_effect_names(without),
        wrench_pose=wrench_pose,
        progress=progress,
    )
    named = recording.name if isinstance(recording, Recording) else os.fspath(recording)
    command = command or f"trundle diagnose {named} --seed {seed}"
    return build_diagnosis(recording, outcome, seed, command, model, doubts)


def build_diagnosis(
    recording: Recording | PathLike,
    outcome: _native._Outcome,
    seed: int,
    command: str,
    model: Model | PathLike | None,
    doubts: Sequence[str],
) -> Diagnosis:
    """Return a diagnosis with its report."""
    answer, series = json.loads(outcome.answer), json.loads(outcome.series)
    series |= {key: answer.get(key, []) for key in ("certificates", "experiments")}
    series |= {
        "seed": seed,
        "version": _native.__version__,
        "input": inputs(recording=recording, model=model),
        "command": command,
        "doubts": [*doubts, *answer.get("warnings", [])],
    }
    return Diagnosis(answer, Model.from_toml(outcome.model), render(answer, series), series, outcome)


def check_effect_names(names: Sequence[str]) -> list[str]:
    """Return names of effects, each of which must be in the catalogue."""
    effects = sorted({effect["effect"] for effect in _native.effects()})
    for name in names:
        if name not in effects:
            raise _native.TrundleError(f"without: unknown effect `{name}`; known are {', '.join(effects)}")
    return list(names)


def native_recordings(
    recordings: Recording | PathLike | Sequence[Recording | PathLike],
) -> list[Recording | str]:
    """Return what the native functions take for one or several recordings."""
    if isinstance(recordings, Recording | str | os.PathLike):
        return [native_recording(recordings)]
    return [native_recording(recording) for recording in recordings]


def native_recording(recording: Recording | PathLike) -> Recording | str:
    """Return what the native functions take for a recording."""
    return recording if isinstance(recording, Recording) else os.fspath(recording)


def model_text(model: Model | PathLike | None) -> str | None:
    """Return the text of a model, given as itself or as the path of its file."""
    if model is None:
        return None
    return (model if isinstance(model, Model) else Model.read(model)).to_toml()
