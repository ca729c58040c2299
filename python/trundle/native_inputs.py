"""Recordings and models as the native functions expect them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TypeAlias

from trundle import _native
from trundle._native import JointRecording, Model, Recording

__all__ = ["PathLike", "native_model", "native_recording", "native_recordings", "read_model"]

PathLike: TypeAlias = "str | os.PathLike[str]"


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
