"""Twist and acceleration from noisy poses, compared with the truth."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle
from tests.record_prepare.table import NOISE, Table, recording, simulate

Floats = NDArray[np.float64]
TABLE = Table(episodes=3, metadata={"noise": NOISE})


def errors(order: str, causal: bool) -> tuple[Floats, Floats]:
    """Standardised and absolute errors of all axes from the first movement on."""
    smoothed = trundle.smooth(recording(TABLE), causal=causal)
    standardised, absolute = [], []
    for index, motion in enumerate(smoothed.values()):
        truth = simulate(TABLE, index)
        at = np.searchsorted(truth.t, motion["t"] - 1e-9)
        moving = motion["t"] > TABLE.quiet + 0.1
        which = ["pose", "twist", "accel"].index(order)
        error = (motion[order] - getattr(truth, order)[at])[moving]
        if order == "pose":
            error[:, 2] = np.angle(np.exp(1j * error[:, 2]))
        standardised.append(error / np.sqrt(motion["cov"][moving][:, :, which, which]))
        absolute.append(error)
    return np.concatenate(standardised), np.concatenate(absolute)


@pytest.mark.parametrize("causal", [False, True], ids=["smoother", "filter"])
@pytest.mark.parametrize("order", ["pose", "twist", "accel"])
def test_stated_uncertainty_covers_the_truth(order: str, causal: bool) -> None:
    standardised, _ = errors(order, causal)
    assert (np.abs(standardised) < 2.0).mean() > 0.88
    assert 0.1 < (standardised**2).mean() < 2.5


def test_twists_are_accurate_to_centimetres_per_second() -> None:
    _, absolute = errors("twist", causal=False)
    assert np.sqrt((absolute[:, :2] ** 2).mean()) < 0.01
    assert np.sqrt((absolute[:, 2] ** 2).mean()) < 0.03


def test_before_contact_the_object_rests() -> None:
    for motion in trundle.smooth(recording(TABLE)).values():
        resting = motion["t"] < TABLE.quiet - 0.25
        assert resting.any() and not motion["twist"][resting].any()


def test_fewer_than_five_poses_have_no_motion() -> None:
    whole = recording(TABLE)
    episodes = whole.episodes
    columns = {name: np.array(values) for name, values in episodes["episode_00"].items()}
    poses = np.flatnonzero(~np.isnan(columns["object_x"]))[4:]
    for name in ("object_x", "object_y", "object_theta"):
        columns[name][poses] = np.nan
    columns_left = {name: values for name, values in columns.items()}
    cut = trundle.Recording(whole.metadata, {"episode_00": drop_empty(columns_left)})
    assert trundle.smooth(cut)["episode_00"]["twist"].shape == (0, 3)
    assert trundle.inspect(cut).episodes[0].peak_speed is None


def drop_empty(columns: dict[str, Floats]) -> dict[str, Floats]:
    """Drop rows without a sample."""
    held = ~np.all([np.isnan(values) for name, values in columns.items() if name != "t"], axis=0)
    return {name: values[held] for name, values in columns.items()}
