"""Estimation of models from recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias

from trundle import _native
from trundle._native import Model, Recording, TrundleError
from trundle._types import FitSummary
from trundle.black_box import Step
from trundle.display import Card, Displayed
from trundle.native_inputs import PathLike, native_model, native_recordings
from trundle.progress import ProgressOption, report_progress

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Fit", "Likelihood", "fit"]

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
