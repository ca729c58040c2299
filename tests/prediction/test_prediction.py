"""`trundle.predict`: open-loop predictions as data and as a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import trundle

WHEEL = """
format = "trundle-model/1"
[body]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
mass = 22.0
[[effect]]
kind = "viscous_wheel"
x = -0.5
y = 0.3
angle = 0.3
mu_x = 180.0
mu_y = 320.0
"""


@pytest.fixture(scope="module")
def recording() -> trundle.Recording:
    return trundle.demo()


@pytest.fixture(scope="module")
def prediction(recording: trundle.Recording) -> trundle.Prediction:
    return trundle.predict(recording, trundle.Model.from_toml(WHEEL))


def test_every_pose_of_the_recording_is_predicted(
    recording: trundle.Recording, prediction: trundle.Prediction
) -> None:
    assert list(prediction) == list(recording)
    held_out = [name for name, one in prediction.items() if one.held_out]
    assert held_out == recording.metadata["split"]["held_out"]
    prepared = trundle.prepare(recording)
    for name, one in prediction.items():
        np.testing.assert_array_equal(one.t, prepared[name]["pose_t"])
        np.testing.assert_array_equal(one.observed, prepared[name]["pose"])
        np.testing.assert_array_equal(one.error, one.predicted - one.observed)


def test_the_metrics_are_those_of_the_scored_poses(prediction: trundle.Prediction) -> None:
    errors = [one.error[one.scored, :2] for one in prediction.values() if one.held_out]
    rmse = np.sqrt(np.mean(np.sum(np.concatenate(errors) ** 2, axis=1)))
    assert prediction.held_out is not None and prediction.held_out["position_rmse"] == pytest.approx(
        rmse, rel=1e-6
    )
    assert rmse > 0.1  # m: the model has no dry friction


def test_a_file_is_written_only_if_it_is_named(
    recording: trundle.Recording,
    prediction: trundle.Prediction,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    model = trundle.Model.from_toml(WHEEL)
    trundle.predict(recording, model)
    assert not list(tmp_path.iterdir())
    trundle.predict(recording, model, tmp_path / "p.parquet")
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    stored = pandas.read_parquet(tmp_path / "p.parquet")
    for column in ("t", "observed_x", "predicted_theta"):
        np.testing.assert_array_equal(stored[column], prediction.frame()[column])


def test_another_extension_and_a_free_parameter_are_refused(
    recording: trundle.Recording, tmp_path: Path
) -> None:
    model = trundle.Model.from_toml(WHEEL)
    with pytest.raises(trundle.TrundleError, match=r"p\.csv: only \.parquet files are written"):
        trundle.predict(recording, model, tmp_path / "p.csv")
    with pytest.raises(trundle.TrundleError, match="mu_x"):
        trundle.predict(recording, trundle.Model.from_toml(WHEEL.replace("mu_x = 180.0\n", "")))
    assert not list(tmp_path.iterdir())
    with pytest.raises(trundle.TrundleError, match="'nowhere' is no episode of"):
        trundle.predict(recording, model)["nowhere"]
