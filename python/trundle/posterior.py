"""Posterior draws of the parameters of a model, and convergence diagnostics."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from trundle import _native
from trundle._native import Model, Recording, TrundleError
from trundle._optional import require
from trundle.atomic import atomic_file
from trundle.display import Card, Displayed
from trundle.native_inputs import native_model, native_recording
from trundle.progress import ProgressOption, report_progress

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["Posterior", "sample"]

PathLike: TypeAlias = "str | os.PathLike[str]"
Array: TypeAlias = NDArray[np.float64]
Method: TypeAlias = Literal["nuts", "laplace", "metropolis"]

MAX_R_HAT = 1.01
"""Maximum R-hat of converged chains (Vehtari et al. 2021)."""
TAILS = (0.05, 0.95)
"""Quantiles of the effective sample size of the tails. ArviZ 1 has no default for arrays."""
MIN_EFFECTIVE_DRAWS = 400
"""Minimum effective sample size for reliable R-hat and quantiles (Vehtari et al. 2021)."""


@dataclass(frozen=True, repr=False)
class Posterior(Displayed):
    """Draws of a posterior.

    Attributes
    ----------
    summary : dict
        ``recording``, ``method``, ``parameters`` (name, unit, identifiable, r_hat, ess_bulk, ess_tail and,
        if identifiable, mean, sd and the ends low and high of the central 90 % interval), ``modes`` (values
        and share of the evidence of each mode in which chains start), ``noise``, ``lack_of_fit`` (as in the
        summary of `trundle.fit`), ``converged``, ``verdict``, ``divergences``.
    draws : dict of str to ndarray, shape (chain, draw)
        Each free parameter, SI units. A wheel turned by 90° with exchanged coefficients is the same wheel.
        Draws are therefore normalised: "along" is the direction of least friction, and angles lie within
        half a period of the mode.
    stats : dict of str to ndarray, shape (chain, draw)
        ``lp`` (log density, not normalised), ``diverging``, ``n_steps`` (evaluations of the density).
    seed : int

    Examples
    --------
    >>> posterior = trundle.sample(recording, "free.toml", draws=50, starts=2)
    >>> posterior.draws["coulomb_friction.force"].shape  # chains, draws
    (4, 50)
    >>> posterior.log_likelihood.dims
    ('chain', 'draw', 'episode')
    """

    summary: dict[str, Any]
    draws: dict[str, Array]
    stats: dict[str, NDArray[Any]]
    seed: int
    _native: _native._Posterior

    @property
    def converged(self) -> bool:
        """Whether the chains agree, have enough effective draws and did not diverge."""
        return bool(self.summary["converged"])

    def plot(self) -> Figure:
        """Draw the marginals and the pairs of parameters, see `trundle.plots.posterior`."""
        from trundle import plots

        return plots.posterior(self)

    @cached_property
    def predictive(self) -> dict[str, xr.DataArray]:
        """Posterior predictive poses of training and held-out episodes: dimensions chain, draw, time, axis.

        For 50 evenly spaced draws of each chain, with new samples of the wrench noise, the tare error and
        the pose noise. Time is in s; the axes are x, y (m) and theta (rad). The attribute ``held_out`` is 1
        for held-out episodes.
        """
        return {name: predicted for name, (predicted, _) in self._predicted.items()}

    @cached_property
    def log_likelihood(self) -> xr.DataArray:
        """Log likelihood of each training episode at each draw, nats: dimensions chain, draw, episode.

        The points of ``arviz.loo`` are episodes, because only episodes are independent given the parameters:
        the samples of one episode share its tare error, its initial state and the filter's memory. ArviZ thus
        estimates how well the model predicts a new episode. With the Laplace approximation the estimate is
        that of the approximate posterior.
        """
        xarray = require("xarray", "arviz", "xarray arrays")
        episodes, values = self._native.log_likelihood()
        coords = {
            "chain": np.arange(values.shape[0]),
            "draw": np.arange(values.shape[1]),
            "episode": episodes,
        }
        found: xr.DataArray = xarray.DataArray(
            values, coords, ("chain", "draw", "episode"), attrs={"units": "nats"}
        )
        return found

    @cached_property
    def _predicted(self) -> dict[str, tuple[xr.DataArray, xr.DataArray]]:
        """Return predicted and observed poses by episode."""
        xr = import_xarray()
        found = {}
        for name, (held_out, t, seen, poses) in self._native.predictive(50, self.seed).items():
            kept, count = next(iter(self.draws.values())).shape[1], poses.shape[1]
            coords = {"time": t, "axis": ["x", "y", "theta"]}
            chosen = {"chain": np.arange(len(poses)), "draw": np.arange(count) * kept // count}
            attrs = {"held_out": int(held_out), "units": "m, m, rad"}
            predicted = xr.DataArray(
                poses, {**chosen, **coords}, ("chain", "draw", "time", "axis"), attrs=attrs
            )
            found[name] = (predicted, xr.DataArray(seen, coords, ("time", "axis"), attrs=attrs))
        return found

    def groups(self) -> dict[str, xr.Dataset]:
        """Return the ArviZ groups: posterior, sample_stats, log_likelihood and those of the predictions.

        In ``posterior_predictive`` and ``observed_data``, the poses of an episode are the variable
        ``pose_NAME`` with the dimension ``time_NAME``. In ``log_likelihood``, the variable ``episodes`` has
        the dimensions chain, draw and episode; see `log_likelihood`.
        """
        xarray = import_xarray()

        def table(columns: dict[str, NDArray[Any]]) -> xr.Dataset:
            dims = ("chain", "draw")
            shape = next(iter(columns.values())).shape
            coords = {name: np.arange(n) for name, n in zip(dims, shape, strict=True)}
            variables = {name: (dims, values) for name, values in columns.items()}
            found: xr.Dataset = xarray.Dataset(variables, coords)
            return found

        def poses(which: int) -> xr.Dataset:
            named = {
                f"pose_{name}": pair[which].rename(time=f"time_{name}")
                for name, pair in self._predicted.items()
            }
            found: xr.Dataset = xarray.Dataset(named)
            return found

        posterior = table(dict(self.draws))
        for parameter in self.summary["parameters"]:
            posterior[parameter["name"]].attrs = {
                "units": parameter["unit"],
                "identifiable": int(parameter["identifiable"]),
            }
        posterior.attrs = {
            "inference_library": "trundle",
            "inference_library_version": _native.__version__,
            "converged": int(self.converged),
            "verdict": self.summary["verdict"],
        }
        return {
            "posterior": posterior,
            "sample_stats": table(self.stats),
            "log_likelihood": xarray.Dataset({"episodes": self.log_likelihood}),
            "posterior_predictive": poses(0),
            "observed_data": poses(1),
        }

    def to_inference_data(self) -> Any:
        """Return an ``arviz.InferenceData``, or an ``xarray.DataTree`` with ArviZ 1.

        Examples
        --------
        >>> import arviz
        >>> data = posterior.to_inference_data()
        >>> int(arviz.loo(data).n_data_points)  # the training episodes
        2
        """
        az = import_arviz()
        if az.__version__.startswith("0."):  # version 1 has a placeholder of the same name
            return az.InferenceData(**self.groups())
        return import_xarray().DataTree.from_dict(self.groups())

    def write(self, path: PathLike) -> Path:
        """Write all groups as netCDF, atomically, for ``arviz.from_netcdf``; return the path."""
        require("h5netcdf", "arviz", "netCDF files")
        target = Path(path)
        with atomic_file(target) as part:
            import_xarray().DataTree.from_dict(self.groups()).to_netcdf(part, engine="h5netcdf")
        return target

    def _card(self) -> Card:
        from trundle.display.results import posterior_card  # takes long to import

        return posterior_card(self.summary)


def sample(
    recording: Recording | PathLike,
    model: Model | PathLike | None = None,
    *,
    method: Method = "laplace",
    chains: int = 4,
    draws: int = 250,
    warmup: int = 150,
    starts: int = 6,
    seed: int = 0,
    prior: PathLike | None = None,
    progress: ProgressOption = None,
) -> Posterior:
    """Sample the posterior of a model's free parameters given the training episodes of a recording.

    Parameters
    ----------
    recording : Recording or path
    model : Model or path, optional
        Parameters without a value are sampled. By default the paper's model (eq. 3).
    method : {"laplace", "nuts", "metropolis"}
        "laplace": independent draws from the normal approximation at the mode (seconds); "nuts": the
        No-U-Turn sampler (minutes to hours, depending on the number and length of the episodes);
        "metropolis": random-walk Metropolis, as in the predecessor of the paper's method.
    chains, draws, warmup : int
        Number of chains, draws per chain, and warm-up draws in which the sampler adapts its steps. The
        density is scaled by its curvature at the mode, so NUTS needs few of either.
    starts : int
        Number of searches for modes before sampling.
    seed : int
        Random seed. The same input and seed give the same bytes, on any number of cores.
    prior : path, optional
        A prior file, as for `trundle.fit`.
    progress : bool or callable, optional
        True shows a progress bar; the default shows one in notebooks only. A function is called with the
        stage of the work and the finished share of all work, 0 to 1, which never decreases.

    Returns
    -------
    Posterior
        Check ``converged`` and ``summary["verdict"]`` before use.

    Raises
    ------
    TrundleError
        If there is not enough data, no parameter is free, a setting is invalid, or the extra
        `trundle[arviz]` is not installed.

    Examples
    --------
    >>> posterior = trundle.sample(recording, "free.toml", draws=50, starts=2)
    >>> posterior.summary["parameters"][0]["name"]
    'coulomb_friction.force'
    """
    for name, value in {"chains": chains, "draws": draws, "warmup": warmup, "starts": starts}.items():
        if value < 0:
            raise TrundleError(f"{name} = {value}: must not be negative")
    if starts < 1:
        raise TrundleError(f"starts = {starts}: at least one start is needed")
    import_arviz()  # before the sampler runs for minutes
    prior_file = None if prior is None else (str(prior), Path(prior).read_text(encoding="utf-8"))
    with report_progress(progress, "sample") as report:
        native = _native._sample(
            native_recording(recording),
            native_model(model),
            prior=prior_file,
            method=method,
            chains=chains,
            draws=draws,
            warmup=warmup,
            starts=starts,
            seed=seed,
            progress=report,
        )
    summary: dict[str, Any] = {**native.summary, "method": method, "seed": seed}
    array = native.draws()
    named = {p["name"]: array[:, :, k] for k, p in enumerate(summary["parameters"])}
    stats = native.stats()
    return Posterior(add_diagnostics(summary, named, stats), named, stats, seed, native)


def add_diagnostics(
    summary: dict[str, Any], draws: dict[str, Array], stats: dict[str, NDArray[Any]]
) -> dict[str, Any]:
    """Return the summary with diagnostics of each parameter and a verdict on the chains."""
    diverging = int(stats["diverging"].sum())
    parameters = [
        parameter_diagnostics(parameter, draws[parameter["name"]]) for parameter in summary["parameters"]
    ]
    faults = [fault for parameter in parameters for fault in chain_faults(parameter)]
    if next(iter(draws.values())).shape[0] < 2:
        faults.append("R-hat needs at least two chains")
    if diverging:
        faults.append(f"{diverging} trajectories diverged")
    if summary["method"] == "laplace":
        verdict = "Laplace approximation: a normal distribution at the mode, not checked against the density"
        if len(summary["modes"]) > 1:
            verdict += f"; {len(summary['modes'])} modes, weighted by evidence"
        faults = []
    elif faults:
        verdict = "NOT CONVERGED: " + "; ".join(faults)
    else:
        verdict = (
            f"converged: R-hat at most {MAX_R_HAT}, at least {MIN_EFFECTIVE_DRAWS} effective draws, "
            "no divergence"
        )
    found = {"parameters": parameters, "converged": not faults, "verdict": verdict, "divergences": diverging}
    return summary | found


def parameter_diagnostics(parameter: dict[str, Any], draws: Array) -> dict[str, Any]:
    """Return a parameter with diagnostics of its chains and, if it is identifiable, its estimate."""
    az = import_arviz()
    found = dict(parameter)
    found["r_hat"] = float(az.rhat(draws, method="rank")) if len(draws) > 1 else None
    found["ess_bulk"] = float(az.ess(draws, method="bulk"))
    found["ess_tail"] = float(az.ess(draws, method="tail", prob=TAILS))
    if parameter["identifiable"]:
        low, high = (float(q) for q in np.quantile(draws, [0.05, 0.95]))
        found |= {"mean": float(draws.mean()), "sd": float(draws.std()), "low": low, "high": high}
    return found


def chain_faults(parameter: dict[str, Any]) -> list[str]:
    """Return descriptions of the convergence faults of a parameter's chains."""
    name, faults = parameter["name"], []
    r_hat, ess = parameter["r_hat"], min(parameter["ess_bulk"], parameter["ess_tail"])
    if r_hat is not None and not r_hat <= MAX_R_HAT:
        faults.append(f"{name} has R-hat {r_hat:.3f}")
    if not ess >= MIN_EFFECTIVE_DRAWS:
        faults.append(f"{name} has {ess:.0f} effective draws")
    return faults


def import_arviz() -> Any:
    """Import ArviZ without its FutureWarning about the next version."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FutureWarning)
        return require("arviz", "arviz", "posterior samples")


def import_xarray() -> Any:
    """Import xarray."""
    return require("xarray", "arviz", "posterior samples")
