"""Plots of recordings, fits and pose residuals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import trundle
from tests.conftest import RealData
from tests.plots.conftest import RAIL
from tests.plots.figures import caption, labels, legend_texts, lines, title, titled


def test_one_episode_shows_its_wrench_and_motion(recording: trundle.Recording) -> None:
    figure = trundle.plots.recording(recording, "episode_01")
    prepared = trundle.prepare(recording)["episode_01"]
    by_label = {axes.get_ylabel(): axes for axes in figure.axes}
    assert set(by_label) == {"y (m)", "force (N)", "torque (N·m)", "position (cm)", "heading (°)"}
    force = dict(lines(by_label["force (N)"]))
    for column, name in enumerate("xy"):
        np.testing.assert_array_equal(force[name][:, 0], prepared["wrench_t"])
        np.testing.assert_array_equal(force[name][:, 1], prepared["on_object"][:, column])
    position = dict(lines(by_label["position (cm)"]))
    moved = 100.0 * (prepared["pose"][:, 0] - prepared["pose"][0, 0])
    np.testing.assert_allclose(position["x"][:, 1], moved)
    path = dict(lines(by_label["y (m)"]))["path of the origin"]
    np.testing.assert_array_equal(path, prepared["pose"][:, :2])
    assert any(text.startswith("force, at most") for text in legend_texts(figure))


def test_all_episodes_have_a_row_and_a_path(recording: trundle.Recording) -> None:
    figure = trundle.plots.recording(recording)
    training, held_out = (
        titled(figure, "paths of the origin, training"),
        titled(figure, "paths of the origin, held"),
    )
    assert [len(list(lines(axes))) for axes in (training, held_out)] == [2, 1]
    rows = [axes.get_ylabel() for axes in figure.axes if axes.get_ylabel().startswith("episode")]
    assert rows == ["episode_00", "episode_01", "episode_02\n(held out)"]
    assert "3 episodes, 1 held out" in caption(figure)


def test_a_path_is_read(recording: trundle.Recording, tmp_path: Path) -> None:
    recording.write(tmp_path / "table")
    assert labels(trundle.plots.recording(tmp_path / "table")) == labels(trundle.plots.recording(recording))


def test_a_fit_is_compared_with_the_recorded_poses(recording: trundle.Recording, fitted: trundle.Fit) -> None:
    figure = fitted.plot(recording)
    shown = [title(axes) for axes in figure.axes if "episode" in title(axes)]
    assert shown == ["episode_02 (held out)", "episode_00 (training)", "episode_01 (training)"]
    drawn = dict(lines(titled(figure, "episode_02")))
    pose = trundle.prepare(recording)["episode_02"]["pose"]
    np.testing.assert_allclose(drawn["recorded"], pose[:, :2], atol=1e-9)
    assert drawn["fitted model"].shape == drawn["recorded"].shape
    assert np.abs(drawn["fitted model"] - drawn["recorded"]).max() < 0.02
    assert "training 1.2 mm, held out 3.4 mm" in caption(figure)


def test_residuals_are_recorded_minus_simulated(recording: trundle.Recording, fitted: trundle.Fit) -> None:
    pair = dict(lines(titled(trundle.plots.fit(fitted, recording, "episode_00"), "episode_00")))
    gap = pair["recorded"] - pair["fitted model"]
    figure = trundle.plots.residual(fitted.model, recording, ["episode_00"])
    assert [title(axes) for axes in figure.axes] == ["x (mm)", "y (mm)", "heading (°)"]
    for axes, column in zip(figure.axes, gap.T, strict=False):
        ((_, points),) = lines(axes)
        np.testing.assert_allclose(points[:, 1], 1e3 * column, atol=1e-9)
        low, high = axes.get_ylim()
        assert low == -high and high >= np.abs(points[:, 1]).max()
    assert "noise (two standard deviations)" in legend_texts(figure)


def test_unknown_episodes_are_refused(recording: trundle.Recording, fitted: trundle.Fit) -> None:
    expected = "no episode `episode_99` in table; the episodes are episode_"
    with pytest.raises(trundle.TrundleError, match=expected):
        trundle.plots.recording(recording, "episode_99")
    with pytest.raises(trundle.TrundleError, match=expected):
        trundle.plots.fit(fitted, recording, ["episode_00", "episode_99"])
    with pytest.raises(trundle.TrundleError, match=expected):
        trundle.plots.residual(fitted, recording, "episode_99")
    with pytest.raises(trundle.TrundleError, match="at least one episode"):
        trundle.plots.fit(fitted, recording, [])


def test_a_model_without_a_recording_is_refused(fitted: trundle.Fit) -> None:
    with pytest.raises(trundle.TrundleError, match="the recording is missing"):
        trundle.plots.residual(fitted)


def test_a_recording_is_drawn_on_a_subfigure(recording: trundle.Recording) -> None:
    whole = Figure(figsize=(12, 6))
    left, right = whole.subfigures(1, 2, squeeze=False)[0]
    assert trundle.plots.recording(recording, "episode_00", figure=left) is whole
    assert len(left.axes) == 5 and not right.axes


def test_quasi_static_pushes_are_drawn(real_data: RealData) -> None:
    from examples import real_recordings

    pushes = real_recordings.pushes(real_data("cmu-planar-push").parent)
    figure = trundle.plots.recording(next(iter(pushes.values())))
    assert "the first 8 over time" in caption(figure)


def test_an_axis_has_no_top_view(real_data: RealData) -> None:
    from examples import real_recordings

    axis = real_recordings.emps(real_data("emps").parent)
    assert {axes.get_title(loc="left") for axes in trundle.plots.recording(axis).axes} == {
        "force (N)",
        "position (cm)",
        "",
    }
    figure = trundle.plots.residual(trundle.Model.from_toml(RAIL), axis)
    assert [axes.get_ylabel() for axes in figure.axes] == ["episode_01\n(held out)", "episode_00"]
