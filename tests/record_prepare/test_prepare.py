"""The wrench on the object against the truth of the simulated table."""

from __future__ import annotations

import numpy as np
import pytest

import trundle
from tests.record_prepare.table import GRASP, Table, metadata, recording, simulate, tables, transport

TABLE = Table(episodes=2)


def test_the_tared_wrench_is_the_push_on_the_object() -> None:
    for index, episode in enumerate(trundle.prepare(recording(TABLE)).values()):
        truth = simulate(TABLE, index)
        at = np.searchsorted(truth.t, episode["wrench_t"] - 1e-9)
        error = episode["reading"] - truth.reading[at]
        assert np.abs(error.mean(axis=0)).max() < 0.2
        assert error.std(axis=0) == pytest.approx([0.4, 0.4, 0.05], rel=0.15)
        expected = np.array([transport(GRASP, reading) for reading in truth.reading[at]])
        assert np.abs((episode["on_object"] - expected).mean(axis=0)).max() < 0.25


def test_the_error_of_the_tare_is_reported() -> None:
    standardised = []
    for seed in range(12):
        table = Table(episodes=1, seconds=2.0, seed=seed)
        [episode] = trundle.prepare(recording(table)).values()
        truth = simulate(table, 0)
        at = np.searchsorted(truth.t, episode["wrench_t"] - 1e-9)
        pushed = episode["wrench_t"] > table.quiet
        error = (episode["reading"] - truth.reading[at])[pushed].mean(axis=0)
        assert episode["tare_sd"] == pytest.approx(np.array([0.4, 0.4, 0.05]) / 56**0.5, rel=0.6)
        standardised.append(error / episode["tare_sd"])
    assert 0.6 < np.std(standardised) < 1.6


def test_contact_is_found() -> None:
    for index, episode in enumerate(trundle.prepare(recording(TABLE)).values()):
        truth = simulate(TABLE, index)
        felt = truth.t[np.hypot(*truth.reading[:, :2].T) > 4.0][0]
        assert episode["contact"] == pytest.approx(felt, abs=0.03)


def test_equation_12_is_available_and_unknown_methods_are_refused() -> None:
    clean = recording(TABLE)
    turned = trundle.prepare(clean, tare="equation_12")["episode_00"]
    plain = trundle.prepare(clean)["episode_00"]
    assert (
        np.abs(turned["reading"][-1] - plain["reading"][-1]).max() > 0.2
    )  # the offset turned with the gripper
    with pytest.raises(trundle.TrundleError, match="equation_12"):
        trundle.prepare(clean, tare="none")  # type: ignore[arg-type]


def test_outliers_are_masked_and_counted() -> None:
    episodes = tables(TABLE)
    columns = episodes["episode_00"]
    rows = np.flatnonzero(~np.isnan(columns["object_x"]))
    fake = rows[120:150]
    for name, value in (("object_x", 0.66854), ("object_y", -0.26052), ("object_theta", 0.1)):
        columns[name][fake] = value
    columns["object_y"][rows[200]] += 0.01
    dirty = trundle.Recording(metadata(TABLE), episodes)
    kept = trundle.prepare(dirty)["episode_00"]["pose_t"]
    assert not np.isin(columns["t"][[*fake, rows[200]]], kept).any()
    assert trundle.inspect(dirty).episodes[0].counts.pose_outliers == 31
