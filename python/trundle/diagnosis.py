"""Estimation and diagnosis of models from recordings."""

from __future__ import annotations

import difflib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, cast, overload

from trundle import _native
from trundle._native import JointRecording, Model, Recording, TrundleError
from trundle._types import Answer, FitSummary
from trundle.atomic import atomic_folder
from trundle.black_box import Parameters, Step, parse_parameters
from trundle.display import Card, Displayed
from trundle.input_checks import name_of, require_usable
from trundle.joint_diagnosis import JointDiagnosis, diagnose_joints, open_joints
from trundle.progress import ProgressOption, report_progress
from trundle.report import inputs, render

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Diagnosis", "Fit", "diagnose", "fit"]

PathLike: TypeAlias = "str | os.PathLike[str]"
Likelihood: TypeAlias = Literal["filter", "steps", "final", "windows", "wrench"]


@dataclass(frozen=True, repr=False)
class Fit(Displayed):
    """A model fitted to a recording.

    Attributes
    ----------
    model : Model
        The model with all values, and its posterior.
    summary : dict
        Results in SI units:

        - ``parameters``: a list of name, mean, sd, low, high, unit, identifiable. ``low`` and ``high`` are
          the ends of the 90 % interval. A parameter that is not identifiable has no numbers.
        - ``log_evidence``, ``converged``, ``quasi_static``, ``noise``.
        - ``lack_of_fit``: found, gain_nats, residual_force_rms, residual_torque_rms; None if not tested.
        - ``intervals``: basis ("curvature" or "sandwich"), and the number of episodes of the latter.
        - ``identifiability``: identifiable directions and combinations, and the number of starts that agree.
          Absent if a caller's prior excludes the data.
        - ``training`` and ``held_out``: error metrics; None where a metric does not apply.

    Examples
    --------
    >>> fitted = trundle.fit(recording, "free.toml")
    >>> fitted.explains_data
    True
    >>> fitted.model.write("fitted.toml")
    """

    model: Model
    summary: FitSummary

    @property
    def explains_data(self) -> bool | None:
        """Whether the lack-of-fit test passes; None if there is no test.

        The test applies to the default likelihood of motion, with parameters shared by all episodes. If the
        model does not explain the data, `trundle.diagnose` searches for the missing effect.
        """
        lack = self.summary["lack_of_fit"]
        return None if lack is None else not lack["found"]

    @property
    def residual_force_rms(self) -> float | None:
        """Root mean square of the force that the model does not explain, N; None if there is no test."""
        lack = self.summary["lack_of_fit"]
        return None if lack is None else float(lack["residual_force_rms"])

    def plot(self, recording: Recording | PathLike) -> Figure:
        """Draw the model in open loop compared with a recording, see `trundle.plots.fit`."""
        from trundle import plots

        return plots.fit(self, recording)

    def _card(self) -> Card:
        from trundle.display.results import fit_card  # takes long to import

        return fit_card(self.summary)


@dataclass(frozen=True, repr=False)
class Diagnosis(Displayed):
    """Result of a diagnosis.

    Attributes
    ----------
    answer : dict
        The content of ``diagnosis.json`` (``trundle-diagnosis/1``).
    model : Model
        The extended model, fitted.
    report : str
        ``report.html``: one page that needs no network and works without scripts.
    series : dict
        The curves in the report by episode, SI units: observed and simulated poses and, if wrenches are
        compared, recorded and required ones (``wrench``: ``t``, ``recorded``, ``before``, ``after``).

    Examples
    --------
    >>> diagnosis.verdict, diagnosis.missing
    ('explained', ['coulomb_friction'])
    >>> before, after = (diagnosis.answer["fit"]["held_out"][side] for side in ("before", "after"))
    >>> after["position_rmse"] < before["position_rmse"]  # m
    True
    """

    answer: Answer
    model: Model
    report: str
    series: dict[str, Any]
    _outcome: _native._Outcome

    @property
    def verdict(self) -> str:
        """One of "consistent", "reparameterised", "explained" and "unexplained"."""
        return str(self.answer["verdict"])

    @property
    def missing(self) -> list[str]:
        """Names of the missing effects, largest contribution first."""
        return [str(effect["effect"]) for effect in self.answer["missing"]]

    def plot(self) -> Figure:
        """Draw maps, probabilities and held-out episodes, see `trundle.plots.diagnosis`."""
        from trundle import plots

        return plots.diagnosis(self)

    def write(self, folder: PathLike) -> Path:
        """Write ``diagnosis.json``, ``report.html``, ``model.toml`` and ``predictions.parquet``.

        Parameters
        ----------
        folder : path
            Created, or replaced atomically if it contains an earlier diagnosis.

        Returns
        -------
        Path
            The folder.

        Raises
        ------
        TrundleError
            If the folder contains anything else.
        """
        with atomic_folder(Path(folder), ANSWER_FILE, "a diagnosis") as partial:
            self._outcome.write(partial)
            (partial / "report.html").write_text(self.report, encoding="utf-8")
        return Path(folder)

    def _card(self) -> Card:
        from trundle.display.results import diagnosis_card

        return diagnosis_card(self.answer)


ANSWER_FILE = "diagnosis.json"
"""File that identifies a folder as a diagnosis."""


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
    progress: ProgressOption = None,
) -> Fit:
    """Fit the free parameters of a model to the training episodes of one or several recordings of an object.

    The result is the maximum a posteriori estimate (docs/estimation.md). The default likelihood is that of
    the poses given the recorded wrench, by the prediction errors of a filter; the noise and the tare error
    of the wrench drive the motion (eq. 5-6 of the paper). For quasi-static pushes it is the likelihood of
    the wrench that the observed motion requires.

    Parameters
    ----------
    recording : Recording or path, or a sequence of them
        Several recordings must be of the same object. Each keeps its own noise, frames and rates.
    model : Model or path, optional
        Parameters without a value are free. By default the paper's model (eq. 3).
    likelihood : {"filter", "steps", "final", "windows", "wrench"}, optional
        "filter": prediction errors of poses; "steps": displacements between samples (eq. 8); "final": last
        pose of each episode (eq. 9); "windows": poses over windows; "wrench": the wrench that the motion
        requires, inertia included. The default is "filter", or "windows" if the object can touch a known
        obstacle or ``step`` is given.
    window : float
        Length of a window, s.
    loss : {"gaussian", "student"}
        Distribution of residuals; Student's t has four degrees of freedom.
    per_episode : sequence of str
        Names of parameters that have a separate value for each episode.
    obstacles : bool, optional
        False ignores the obstacles of the recording.
    step : callable, optional
        A black-box simulator in place of the effects: ``step(state, wrench, dt, values)`` returns the state
        after ``dt`` seconds. States are pose and twist ``[x, y, theta, vx, vy, omega]`` in the world; the
        wrench ``[fx, fy, tau]`` is in object axes about the object's origin; ``values`` contains every
        parameter by name. It is called for one rollout at a time, hundreds of thousands of times.
    prior : path, optional
        A file of priors, which replace those of the catalogue (docs/estimation.md).
    start : mapping of str to float, optional
        An initial value for every free parameter, by the names in the summary, in addition to the random
        starts. With ``starts=0`` it is the only start.
    starts : int
        Number of random starts.
    seed : int
        Random seed. The same input and seed give the same bytes.
    optimiser : {"lm", "lbfgs"}
        Levenberg–Marquardt, or L-BFGS as in the paper, which is slower and finds the same optimum.
    progress : bool or callable, optional
        True shows a progress bar; the default shows one in notebooks only. A function is called with the
        stage of the work and the finished share of all work, 0 to 1, which never decreases.

    Returns
    -------
    Fit

    Raises
    ------
    TrundleError
        If there is not enough data, the model does not fit the object, the recordings contradict each other,
        or a prior is invalid. Exceptions of ``step`` are passed on.

    Examples
    --------
    >>> fitted = trundle.fit(recording, "free.toml", starts=2)
    >>> [parameter["name"] for parameter in fitted.summary["parameters"]]
    ['coulomb_friction.force']
    """
    if starts < (1 if start is None else 0):
        raise TrundleError(f"starts = {starts}: at least one start is needed")
    prior_file = None if prior is None else (str(prior), Path(prior).read_text(encoding="utf-8"))
    choice = {"likelihood": likelihood, "window": window, "loss": loss, "obstacles": obstacles, "step": step}
    with report_progress(progress, "fit") as report:
        summary, fitted = _native._fit(
            native_recordings(recording),
            native_model(model),
            choice=choice,
            per_episode=list(per_episode),
            prior=prior_file,
            start=start,
            starts=starts,
            seed=seed,
            optimiser=optimiser,
            progress=report,
        )
    return Fit(fitted, summary)


@overload
def diagnose(
    recording: JointRecording,
    model: Model | PathLike | None = ...,
    *,
    mjcf: PathLike | None = ...,
    step: Step | None = ...,
    parameters: Parameters | None = ...,
    seed: int = ...,
    without: Sequence[str] = ...,
    wrench_pose: Literal["own_time", "latest"] = ...,
    check: bool = ...,
    progress: ProgressOption = ...,
    command: str | None = ...,
) -> JointDiagnosis: ...
@overload
def diagnose(
    recording: Recording,
    model: Model | PathLike | None = ...,
    *,
    mjcf: PathLike | None = ...,
    step: Step | None = ...,
    parameters: Parameters | None = ...,
    seed: int = ...,
    without: Sequence[str] = ...,
    wrench_pose: Literal["own_time", "latest"] = ...,
    check: bool = ...,
    progress: ProgressOption = ...,
    command: str | None = ...,
) -> Diagnosis: ...
@overload
def diagnose(
    recording: PathLike,
    model: Model | PathLike | None = ...,
    *,
    mjcf: PathLike | None = ...,
    step: Step | None = ...,
    parameters: Parameters | None = ...,
    seed: int = ...,
    without: Sequence[str] = ...,
    wrench_pose: Literal["own_time", "latest"] = ...,
    check: bool = ...,
    progress: ProgressOption = ...,
    command: str | None = ...,
) -> Diagnosis | Any: ...
def diagnose(
    recording: Recording | JointRecording | PathLike,
    model: Model | PathLike | None = None,
    *,
    mjcf: PathLike | None = None,
    step: Step | None = None,
    parameters: Parameters | None = None,
    seed: int = 0,
    without: Sequence[str] = (),
    wrench_pose: Literal["own_time", "latest"] = "own_time",
    check: bool = True,
    progress: ProgressOption = None,
    command: str | None = None,
) -> Diagnosis | JointDiagnosis:
    """Locate where a simulation differs from a recording, and name the missing effects.

    Parameters
    ----------
    recording : Recording, JointRecording or path
        With ``mjcf`` also a CSV log of joints with the columns of a recording: see docs/mechanisms.md.
    model : Model or path, optional
        The simulation under test: its effects, and any values. By default the paper's model. Recordings of
        joints name their own model.
    mjcf : path, optional
        An MJCF or URDF file that replaces the model of a recording of joints.
    step : callable, optional
        A black-box simulator in place of a model: ``step(state, wrench, dt, values)`` returns the state
        after ``dt`` seconds. States are pose and twist ``[x, y, theta, vx, vy, omega]`` of the origin of the
        object frame in the world. The wrench ``[fx, fy, tau]`` is in object axes about that origin and
        includes the wrench of any effect under test. ``values`` contains every parameter by name. The
        function must be deterministic. See docs/your-simulator.md.
    parameters : mapping, optional
        Parameters of that simulator by name: a positive number (with a wide prior), ``(start, lower,
        upper)``, or a dict with ``start`` and any of ``lower``, ``upper``, ``sd`` and ``unit``. If all are
        plain numbers, the diagnosis also tests these values.
    seed : int
        Random seed. The same input and seed give the same bytes.
    without : sequence of str, optional
        Names of effects that are not tested, as in ``trundle effects``.
    wrench_pose : {"own_time", "latest"}
        Pose that transforms each wrench to the object: the smoothed one at the time of the wrench, or the
        latest recorded one (equation 13 of the paper).
    check : bool
        Refuse a recording whose units, sign, axes or clocks are certainly wrong (see `trundle.check`). Use
        False for objects whose size or speed is so unusual that the check mistakes the units.
    progress : bool or callable, optional
        True shows a progress bar; the default shows one in notebooks only. A function is called with the
        stage of the work and the finished share of all work, 0 to 1, which never decreases.
    command : str, optional
        Command that the report shows for reproduction.

    Returns
    -------
    Diagnosis or JointDiagnosis
        The latter for a recording of joints.

    Raises
    ------
    TrundleError
        If units, sign, axes or clocks of the recording are certainly wrong (see `trundle.check`), there is
        not enough data, or the model does not fit the object. With ``step``, if it raises an exception or
        returns anything but six finite numbers: the message names the episode, the time, the state and the
        values, and the exception is the cause.

    Examples
    --------
    >>> diagnosis = trundle.diagnose(recording, "free.toml")
    >>> diagnosis.verdict, diagnosis.missing
    ('consistent', [])
    >>> diagnosis.write("diagnosis").name
    'diagnosis'
    """
    if not isinstance(recording, Recording):
        joints = open_joints(recording, mjcf)
        if joints is not None:
            if model is not None or step is not None or parameters is not None:
                raise TrundleError(
                    f"{name_of(recording)}: `model`, `step` and `parameters` are for pushed objects; "
                    "give the MJCF or URDF file of a mechanism as `mjcf`"
                )
            return diagnose_joints(
                joints,
                mjcf,
                without=without,
                check=check,
                progress=progress,
                command=command,
                source=None if isinstance(recording, JointRecording) else recording,
            )
        recording = cast("Recording | PathLike", recording)
    if mjcf is not None:
        raise TrundleError(f"{name_of(recording)}: `mjcf` is for recordings of joints; remove it")
    warnings = require_usable(recording) if check else []
    if step is not None:
        if model is not None or without:
            raise TrundleError("step: is the simulation under test; remove `model` and `without`")
        described_parameters, given = parse_parameters(parameters)
        with report_progress(progress, "diagnose") as report:
            outcome = _native._diagnose_foreign(
                native_recording(recording),
                step,
                described_parameters,
                given=given,
                seed=seed,
                progress=report,
            )
        command = command or f"trundle.diagnose(..., step=..., seed={seed})"
        return build_diagnosis(recording, outcome, seed, command, model, warnings, is_black_box=True)
    if parameters is not None:
        raise TrundleError("parameters: need `step`; the parameters of a model are in its file")
    with report_progress(progress, "diagnose") as report:
        outcome = _native._diagnose(
            native_recording(recording),
            native_model(model),
            seed=seed,
            without=check_effect_names(without),
            wrench_pose=wrench_pose,
            progress=report,
        )
    command = command or f"trundle diagnose {name_of(recording)} --seed {seed}"
    return build_diagnosis(recording, outcome, seed, command, model, warnings)


def build_diagnosis(
    recording: Recording | PathLike,
    outcome: _native._Outcome,
    seed: int,
    command: str,
    model: Model | PathLike | None,
    warnings: Sequence[str],
    is_black_box: bool = False,
) -> Diagnosis:
    """Build a diagnosis and its report from the result of the native module."""
    answer, series = outcome.answer, outcome.series
    series |= {key: answer.get(key, []) for key in ("certificates", "experiments")}
    series |= {
        "seed": seed,
        "version": _native.__version__,
        "input": inputs(recording=recording, model=model),
        "command": command,
        "black_box": is_black_box,
        "doubts": [*warnings, *answer.get("warnings", [])],
    }
    return Diagnosis(answer, outcome.model, render(answer, series), series, outcome)


def check_effect_names(names: Sequence[str]) -> list[str]:
    """Return the names as a list; raise `TrundleError` for one that is not in the catalogue."""
    effects = sorted({effect["effect"] for effect in _native.effects()})
    for name in names:
        if name not in effects:
            near = [e for e in effects if name in e] or difflib.get_close_matches(name, effects, n=1)
            hint = f"did you mean {' or '.join(f'`{effect}`' for effect in near)}? " if near else ""
            raise _native.TrundleError(
                f"without: unknown effect `{name}`; {hint}The catalogue has {', '.join(effects)}"
            )
    return list(names)


def native_recordings(
    recordings: Recording | PathLike | Sequence[Recording | PathLike],
) -> list[Recording | str]:
    """Return one or several recordings as the native functions expect them."""
    if isinstance(recordings, Recording | JointRecording | str | os.PathLike):
        return [native_recording(recordings)]
    return [native_recording(recording) for recording in recordings]


def native_recording(recording: Recording | PathLike) -> Recording | str:
    """Return a recording as the native functions expect it: itself or the path of its folder.

    Raises
    ------
    TrundleError
        For a recording of joints in memory; the native functions refuse its folder.
    """
    if isinstance(recording, JointRecording):
        return _native._pushed(recording)
    return recording if isinstance(recording, Recording) else os.fspath(recording)


def read_model(model: Model | PathLike) -> Model:
    """Return a model, or the model of a file."""
    return model if isinstance(model, Model) else Model.read(model)


def native_model(model: Model | PathLike | None) -> Model | None:
    """Return a model as the native functions expect it; None for the nominal model."""
    return None if model is None else read_model(model)
