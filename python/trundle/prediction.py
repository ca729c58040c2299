"""Prediction: open-loop simulation of the episodes of a recording."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from trundle import _native
from trundle._native import Model, Recording, TrundleError
from trundle._optional import require
from trundle._types import Score
from trundle.atomic import atomic_file
from trundle.display import Card, Displayed, Table
from trundle.display.formatting import format_number
from trundle.input_checks import name_of
from trundle.native_inputs import native_recording, read_model

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["EpisodePrediction", "Prediction", "predict"]

PathLike: TypeAlias = "str | os.PathLike[str]"
Floats = NDArray[np.float64]
AXES = ("x", "y", "theta")


@dataclass(frozen=True, repr=False, eq=False)
class EpisodePrediction(Displayed):
    """Predicted and recorded poses of an episode.

    Attributes
    ----------
    name : str
    held_out : bool
    t : array of shape (n,)
        Times of the recorded poses, s.
    observed, predicted : array of shape (n, 3)
        Pose of the object frame in the world: x, y (m) and theta (rad).
    scored : boolean array of shape (n,)
        Whether a row counts in the error metrics. Rows do not count while a law's own state, such as the
        angle of a caster, is still unknown.
    """

    name: str
    held_out: bool
    t: Floats
    observed: Floats
    predicted: Floats
    scored: NDArray[np.bool_]

    @property
    def error(self) -> Floats:
        """Predicted minus observed pose, shape (n, 3), m, m, rad."""
        return self.predicted - self.observed

    def _card(self) -> Card:
        facts = [
            ("samples", f"{len(self.t)} over {self.t[-1] - self.t[0]:.2f} s"),
            ("last error", _last(self)),
        ]
        split = "held out" if self.held_out else "training"
        return Card(f"trundle.EpisodePrediction {self.name!r}: {split}", facts)


class Prediction(Mapping[str, EpisodePrediction], Displayed):
    """Open-loop predictions of a recording: a mapping of episode names to predictions.

    Examples
    --------
    >>> prediction = trundle.predict(recording, "model.toml")
    >>> list(prediction)
    ['episode_00', 'episode_01', 'episode_02']
    >>> prediction["episode_00"].predicted.shape == prediction["episode_00"].observed.shape
    True
    """

    def __init__(self, recording: str, native: _native._Predictions) -> None:
        self._recording, self._native = recording, native
        columns, held_out = native.columns(), native.held_out
        names = np.asarray(columns["episode"])
        self._episodes = {
            name: EpisodePrediction(
                name,
                name in held_out,
                *(columns[key][names == name] for key in ("t", "observed", "predicted", "scored")),
            )
            for name in sorted(set(columns["episode"]))
        }

    def __getitem__(self, name: str) -> EpisodePrediction:
        """Return the prediction of an episode; raise `TrundleError` for an unknown name."""
        if name not in self._episodes:
            raise TrundleError(f"{name!r} is no episode of {self._recording}; there are: {', '.join(self)}")
        return self._episodes[name]

    def __contains__(self, name: object) -> bool:
        """Whether there is an episode of this name."""
        return name in self._episodes

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the episodes."""
        return iter(self._episodes)

    def __len__(self) -> int:
        """Return the number of episodes."""
        return len(self._episodes)

    @cached_property
    def _scores(self) -> tuple[Score | None, Score | None]:
        training, held_out = self._native.scores()
        return training, held_out

    @property
    def training(self) -> Score | None:
        """Error metrics of the training episodes (docs/diagnosis.md), SI units; None without episodes.

        A metric that does not apply is None.
        """
        return self._scores[0]

    @property
    def held_out(self) -> Score | None:
        """Error metrics of the held-out episodes; None without held-out episodes."""
        return self._scores[1]

    def frame(self) -> pd.DataFrame:
        """Return one row per pose sample as a pandas data frame.

        Returns
        -------
        pandas.DataFrame
            ``episode``, ``t`` (s), ``scored``, and ``observed_x``, ``observed_y`` (m), ``observed_theta``
            (rad) and the same ``predicted_*``: the columns that `write` writes.

        Raises
        ------
        TrundleError
            If pandas is not installed.

        Examples
        --------
        >>> list(prediction.frame().columns[:4])
        ['episode', 't', 'scored', 'observed_x']
        """
        pandas = require("pandas", "pandas", "data frames")
        episodes = list(self.values())
        columns = {
            "episode": np.repeat([one.name for one in episodes], [len(one.t) for one in episodes]),
            "t": np.concatenate([one.t for one in episodes]),
            "scored": np.concatenate([one.scored for one in episodes]),
        }
        for group in ("observed", "predicted"):
            poses = np.concatenate([getattr(one, group) for one in episodes])
            columns |= {f"{group}_{axis}": poses[:, k] for k, axis in enumerate(AXES)}
        table: pd.DataFrame = pandas.DataFrame(columns)
        return table

    def write(self, path: PathLike) -> Path:
        """Write the columns of `frame` as a Parquet file, atomically.

        Parameters
        ----------
        path : path
            Its name must end with ``.parquet``.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        TrundleError
            If the name ends with anything else.

        Examples
        --------
        >>> prediction.write("predictions.parquet").name
        'predictions.parquet'
        """
        target = parquet_path(path)
        with atomic_file(target) as part:
            self._native.write(part)
        return target

    def _card(self) -> Card:
        rows = [
            (
                one.name,
                "held out" if one.held_out else "training",
                str(len(one.t)),
                format_number(_rms(np.hypot(*one.error[one.scored, :2].T))),
                format_number(_rms(one.error[one.scored, 2])),
                _last(one),
            )
            for one in self.values()
        ]
        heads = ("episode", "split", "poses", "rmse m", "rmse rad", "last error")
        return Card(f"trundle.Prediction of {self._recording!r}, open loop", (), Table(heads, rows))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else float("nan")


def _last(one: EpisodePrediction) -> str:
    x, y, theta = one.error[-1]
    return f"{np.hypot(x, y):.3g} m, {abs(theta):.3g} rad"


def parquet_path(path: PathLike) -> Path:
    """Return the path of a Parquet file; raise `TrundleError` if its name has another extension."""
    target = Path(path)
    if target.suffix != ".parquet":
        raise TrundleError(f"{target}: only .parquet files are written; name it {target.stem}.parquet")
    return target


def predict(
    recording: Recording | PathLike, model: Model | PathLike, out: PathLike | None = None
) -> Prediction:
    """Simulate every episode in open loop.

    Parameters
    ----------
    recording : Recording or path
    model : Model or path
        Must contain a value for every parameter.
    out : path, optional
        Parquet file to write, as `Prediction.write` does. By default nothing is written.

    Returns
    -------
    Prediction
        Recorded and predicted poses by episode, and the error metrics.

    Raises
    ------
    TrundleError
        If a parameter of the model has no value, or the name of ``out`` does not end with ``.parquet``.

    Examples
    --------
    >>> prediction = trundle.predict(recording, "model.toml")
    >>> prediction["episode_02"].held_out
    True
    >>> prediction.held_out["position_rmse"] < 0.1  # m
    True
    """
    if out is not None:
        parquet_path(out)
    name = name_of(recording)
    found = Prediction(name, _native._predict(native_recording(recording), read_model(model)))
    if out is not None:
        found.write(out)
    return found
