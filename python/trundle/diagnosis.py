"""Diagnosis of models from recordings."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, cast, overload

from trundle import _native
from trundle._native import JointRecording, Model, Recording, TrundleError
from trundle._types import Answer
from trundle.atomic import atomic_folder
from trundle.black_box import Parameters, Step, parse_parameters
from trundle.display import Card, Displayed
from trundle.input_checks import name_of, require_usable
from trundle.joint_diagnosis import JointDiagnosis, diagnose_joints, open_joints
from trundle.native_inputs import PathLike, native_model, native_recording
from trundle.progress import ProgressOption, report_progress
from trundle.report import inputs, render

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["ANSWER_FILE", "Diagnosis", "build_diagnosis", "diagnose"]


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


@overload
def diagnose(
    recording: JointRecording,
    model: Model | PathLike | None = ...,
    *,
    mjcf: PathLike | None = ...,
    step: Step | None = ...,
    parameters: Parameters | None = ...,
    vectorized: bool = ...,
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
    vectorized: bool = ...,
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
    vectorized: bool = ...,
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
    vectorized: bool = False,
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
        With ``mjcf`` or ``step`` also a CSV log of joints with the columns of a recording: see
        docs/mechanisms.md.
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
        function must be deterministic. See docs/your-simulator.md. For a recording of n joints,
        ``step(state, effort, dt, values)``: states are positions, then velocities, in the order of the
        recorded joints; efforts act on the joints, N·m or N. See docs/mechanisms.md.
    parameters : mapping, optional
        Parameters of that simulator by name: a positive number (with a wide prior), ``(start, lower,
        upper)``, or a dict with ``start`` and any of ``lower``, ``upper``, ``sd`` and ``unit``. If all are
        plain numbers, the diagnosis also tests these values. Optional for recordings of joints.
    vectorized : bool
        For recordings of joints: whether ``step`` takes states (B, 2n) and efforts (B, n).
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
        returns anything but finite numbers of the right shape: the message names the episode, the time, the
        state and the values, and the exception is the cause.

    Examples
    --------
    >>> diagnosis = trundle.diagnose(recording, "free.toml")
    >>> diagnosis.verdict, diagnosis.missing
    ('consistent', [])
    >>> diagnosis.write("diagnosis").name
    'diagnosis'
    """
    if not isinstance(recording, Recording):
        joints = open_joints(recording, mjcf, has_simulator=step is not None)
        if joints is not None:
            if model is not None:
                raise TrundleError(
                    f"{name_of(recording)}: `model` is for pushed objects; give the MJCF or URDF file of a "
                    "mechanism as `mjcf`, or your simulator as `step`"
                )
            if step is not None and mjcf is not None:
                raise TrundleError("step, mjcf: only one simulation can be tested; give one of them")
            if step is None and (parameters is not None or vectorized):
                raise TrundleError("parameters, vectorized: need `step`; give it too, or remove them")
            from trundle.joint_design import design_alternatives  # takes long to import

            return diagnose_joints(
                joints,
                mjcf,
                step=step,
                parameters=parameters,
                vectorized=vectorized,
                without=check_effect_names(without, _native._joint_effects()),
                check=check,
                progress=progress,
                command=command,
                source=None if isinstance(recording, JointRecording) else recording,
                advise=None if step is not None else design_alternatives,
            )
        recording = cast("Recording | PathLike", recording)
    if mjcf is not None:
        raise TrundleError(f"{name_of(recording)}: `mjcf` is for recordings of joints; remove it")
    if vectorized:
        raise TrundleError(f"{name_of(recording)}: `vectorized` is for recordings of joints; remove it")
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
            without=check_effect_names(without, _native.effects()),
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


def check_effect_names(names: Sequence[str], catalogue: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the names as a list; raise `TrundleError` for one that is not in the catalogue."""
    effects = sorted({effect["effect"] for effect in catalogue})
    for name in names:
        if name not in effects:
            near = [e for e in effects if name in e] or difflib.get_close_matches(name, effects, n=1)
            hint = f"did you mean {' or '.join(f'`{effect}`' for effect in near)}? " if near else ""
            raise TrundleError(
                f"without: unknown effect `{name}`; {hint}The catalogue has {', '.join(effects)}"
            )
    return list(names)
