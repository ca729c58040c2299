"""Online estimation of the parameters of a model, push by push."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trundle import _native
from trundle._native import Model, Recording, TrundleError
from trundle._types import Estimate
from trundle.display import Card, Displayed, Table
from trundle.native_inputs import PathLike
from trundle.report.quantity import format_estimate

__all__ = ["Online"]


class Online(Displayed):
    """Estimate that each push, or each chunk of samples, updates at a bounded cost.

    The log likelihood of each push is approximated by a quadratic in the parameters. A new push updates the
    estimate by a few Gauss-Newton steps. Each update also linearises one earlier push again, so that the
    estimate converges to the fit of all pushes.

    Parameters
    ----------
    metadata : mapping
        Content of ``recording.toml``: object, frames, tare and noise (docs/recordings.md). The split into
        training and held-out episodes does not apply to pushes and is ignored.
    model : Model or path, optional
        Model whose parameters without a value are estimated; by default the paper's model.
    starts, seed : int
        Number of random starts of the search at the first push, and their seed.
    kept : int
        Maximum number of earlier pushes that can be linearised again. Memory grows with their samples only.

    Raises
    ------
    TrundleError
        If a setting, the metadata or the model is invalid.

    Examples
    --------
    >>> online = trundle.Online(recording.metadata, "free.toml", starts=2)
    >>> online.update(recording["episode_00"])
    >>> online.estimate()[0]["name"], online.pushes
    ('coulomb_friction.force', 1)
    """

    def __init__(
        self,
        metadata: Mapping[str, Any],
        model: Model | PathLike | None = None,
        *,
        starts: int = 6,
        seed: int = 0,
        kept: int = 16,
    ) -> None:
        if starts < 1 or kept < 1:
            raise TrundleError(f"starts = {starts}, kept = {kept}: each must be at least one")
        initial = Model.read(model) if isinstance(model, str | os.PathLike) else model
        described = {key: value for key, value in metadata.items() if key != "split"}
        self._native = _native._Online(described, initial, starts=starts, seed=seed, kept=kept)
        self._chunks: list[dict[str, NDArray[np.float64]]] = []

    def update(self, push: Mapping[str, ArrayLike] | Recording | None = None) -> None:
        """Add a complete push to the estimate.

        Parameters
        ----------
        push : mapping of columns, or Recording, optional
            Columns of an episode's table, or a recording each episode of which is a push. By default the
            samples that `extend` received since the last push.

        Raises
        ------
        TrundleError
            If the push is unusable. The estimate is then that before the push, and the samples of `extend`
            are discarded if they are the push.
        """
        if push is not None:
            self._native.update(push)
        else:
            try:
                self._native.update(self._joined())
            except TrundleError:
                self._native.abandon()
                self._start_push()
                raise
        self._start_push()

    def _start_push(self) -> None:
        self._chunks, self.waiting = [], None

    def extend(self, samples: Mapping[str, ArrayLike]) -> None:
        """Add samples to the current push; the estimate then includes the push so far.

        The cost grows with the length of the current push (a few milliseconds for six seconds), not with
        earlier pushes. While the push is too short for a likelihood, the samples are stored only.

        Parameters
        ----------
        samples : mapping of columns
            Columns of an episode's table, the same in each chunk.

        Raises
        ------
        TrundleError
            If the columns differ from those of the first chunk or in length. The chunk is then ignored.
        """
        chunk = {name: np.asarray(column, dtype=float) for name, column in samples.items()}
        names = (self._chunks or [chunk])[0].keys()
        if chunk.keys() != names:
            raise TrundleError(
                f"extend: columns {', '.join(chunk)}: the columns of the first chunk are {', '.join(names)}"
            )
        shapes = {column.shape for column in chunk.values()}
        if len(shapes) != 1 or len(shapes.pop()) != 1:
            found = ", ".join(f"{name} {column.shape}" for name, column in chunk.items())
            raise TrundleError(
                f"extend: columns must be lists of one length; their shapes are {found or 'missing'}"
            )
        self._chunks.append(chunk)
        self.replace(self._joined())

    def replace(self, so_far: Mapping[str, ArrayLike]) -> None:
        """Replace the samples of the current push; the estimate then includes the push so far.

        An unusable push is not an error: `waiting` gives the reason.

        Parameters
        ----------
        so_far : mapping of columns
            All samples since the start of the push.
        """
        try:
            self._native.peek(so_far)
        except TrundleError as refusal:
            self.waiting = str(refusal)
        else:
            self.waiting = None

    waiting: str | None = None
    """Reason why the current push is not in the estimate yet; None if it is."""

    def estimate(self) -> list[Estimate]:
        """Return name, mean, sd, unit and identifiable of each free parameter, as in a fit's summary.

        Mean and sd of a parameter that is not identifiable are None. Before the first push the list is empty.
        """
        return self._native.estimate()

    @property
    def model(self) -> Model | None:
        """The model with the estimated values; None before the first push."""
        return self._native.model()

    @property
    def pushes(self) -> int:
        """Number of complete pushes in the estimate."""
        return self._native.pushes

    @property
    def hypotheses(self) -> int:
        """Number of modes of the posterior that are still tracked."""
        return self._native.hypotheses

    def _card(self) -> Card:
        rows = [
            (
                one["name"],
                format_estimate(one["mean"], one["sd"]) if one["identifiable"] else "not identifiable",
                one["unit"],
            )
            for one in self.estimate()
        ]
        waiting = [("waiting", self.waiting)] if self.waiting else []
        title = f"trundle.Online: {self.pushes} pushes, {self.hypotheses} hypotheses"
        return Card(title, waiting, Table(("parameter", "estimate", "unit"), rows))

    def _joined(self) -> dict[str, NDArray[np.float64]]:
        if not self._chunks:
            raise TrundleError("no push: give its columns, or call extend() with its samples first")
        names = self._chunks[0].keys()
        return {name: np.concatenate([chunk[name] for chunk in self._chunks]) for name in names}
