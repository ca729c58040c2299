"""The estimate kept up to date push by push."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trundle import _native
from trundle._native import Model, Recording, TrundleError
from trundle.diagnosis import PathLike, model_text

__all__ = ["Online"]


class Online:
    """An estimate that each push, or each chunk of samples, refines at a bounded cost.

    Every push is remembered as a quadratic in the parameters; a new one moves the estimate by a few
    Gauss-Newton steps, and one earlier push is looked at again, so that it comes to rest where the fit of all
    pushes does.

    Parameters
    ----------
    metadata : mapping
        What ``recording.toml`` holds: the object, frames, tare and noise (docs/recordings.md).
    model : Model or path, optional
        Values that it leaves out are free; the paper's model if not given.
    starts, seed : int
        Random starts of the search at the first push, and their seed.
    kept : int
        Pushes that are looked at again; memory grows with their samples, not with older pushes.

    Examples
    --------
    >>> online = trundle.Online(metadata)                   # doctest: +SKIP
    >>> online.update(columns_of_a_push)                    # doctest: +SKIP
    >>> online.estimate()[0]                                # doctest: +SKIP
    {'name': 'body.mass', 'mean': 22.1, 'sd': 0.1, 'unit': 'kg', 'identifiable': True}
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
            raise TrundleError(f"starts = {starts}, kept = {kept}: both must be at least one")
        self._metadata = dict(metadata)
        self._native = _native._Online(model_text(model), starts=starts, seed=seed, kept=kept)
        self._chunks: list[dict[str, NDArray[np.float64]]] = []

    def update(self, push: Mapping[str, ArrayLike] | Recording | None = None) -> None:
        """Take a whole push in.

        Parameters
        ----------
        push : mapping of columns, or Recording, optional
            The columns of an episode's table, or a recording whose every episode is a push. Left out, what
            `extend` was given since the last push.

        Raises
        ------
        TrundleError
            If the push cannot be used; the estimate is as before it. What `extend` was given is forgotten, if
            that is the push.
        """
        if isinstance(push, Recording):
            self._native.update(push)
        elif push is not None:
            self._native.update(self._recording(push))
        else:
            try:
                self._native.update(self._recording(self._joined()))
            except TrundleError:
                self._native.abandon()
                self._begin()
                raise
        self._begin()

    def _begin(self) -> None:
        """Begin a new push."""
        self._chunks, self.waiting = [], None

    def extend(self, samples: Mapping[str, ArrayLike]) -> None:
        """Take in the next samples of the push under way: the estimate is that of the push so far.

        The cost grows with the push so far (a few milliseconds for six seconds), not with earlier pushes.
        While there is too little of the push to be compared with a model, the samples are only kept.

        Parameters
        ----------
        samples : mapping of columns
            The same columns in each chunk.

        Raises
        ------
        TrundleError
            If its columns are not those of the first chunk, or no lists of one length: it is not kept.
        """
        chunk = {name: np.asarray(column, dtype=float) for name, column in samples.items()}
        names = (self._chunks or [chunk])[0].keys()
        if chunk.keys() != names:
            raise TrundleError(f"extend: the columns of the first chunk are {', '.join(names)}; give these")
        shapes = {column.shape for column in chunk.values()}
        if len(shapes) != 1 or len(shapes.pop()) != 1:
            told = ", ".join(f"{name} {column.shape}" for name, column in chunk.items())
            raise TrundleError(
                f"extend: columns must be lists of one length, not of shapes {told or 'of none'}"
            )
        self._chunks.append(chunk)
        try:
            recording = self._recording(self._joined())
            self._native.peek(recording)
        except TrundleError as refusal:
            self.waiting = str(refusal)
        else:
            self.waiting = None

    waiting: str | None = None
    """Why the push under way is not in the estimate yet; None when it is."""

    def estimate(self) -> list[dict[str, Any]]:
        """Return name, mean, sd, unit and identifiable of each free parameter, as a fit's summary does.

        What the pushes so far do not hold has no number; before the first push the list is empty.
        """
        rows: list[dict[str, Any]] = json.loads(self._native.estimate())
        return rows

    @property
    def model(self) -> Model | None:
        """The model with every value filled in; None before the first push."""
        text = self._native.filled()
        return None if text is None else Model.from_toml(text)

    @property
    def pushes(self) -> int:
        """How many pushes were taken in."""
        return self._native.pushes

    @property
    def hypotheses(self) -> int:
        """How many explanations are still followed side by side."""
        return self._native.hypotheses

    def _joined(self) -> dict[str, NDArray[np.float64]]:
        if not self._chunks:
            raise TrundleError("no push: give its columns, or its samples to extend() first")
        names = self._chunks[0].keys()
        return {name: np.concatenate([chunk[name] for chunk in self._chunks]) for name in names}

    def _recording(self, columns: Mapping[str, ArrayLike]) -> Recording:
        return Recording(self._metadata, {"push": columns})
