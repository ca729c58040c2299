"""A closed-loop run as an .rrd file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import trundle
from tests.experiments.runs.samples import BOX, history
from tests.viewing.rrd import Rrd


def written(folder: Path) -> Path:
    (folder / "episode_00").mkdir(parents=True)
    (folder / "settings.json").write_text("{}")
    (folder / "episode_00" / "history.json").write_text(json.dumps(history(friction=True)))
    return folder


def test_goal_obstacle_and_estimate_are_shown(tmp_path: Path) -> None:
    rrd = Rrd(trundle.view(written(tmp_path / "run"), tmp_path / "run.rrd"))
    stored = history(friction=True)
    times, x = rrd.array("/plots/position/x_recorded", "scalars")
    assert x.tolist() == [stored["first"]["pose"][0], *(row["pose"][0] for row in stored["steps"])]
    np.testing.assert_allclose(times, [0.0, *(row["t"] for row in stored["steps"])], atol=1e-6)
    assert rrd.only("/scene/goal", "translation") == [[2.0, 0.0, 0.0]]
    np.testing.assert_allclose(np.array(rrd.only("/scene/obstacles", "strips")[0])[:4, :2], BOX, atol=1e-6)
    estimates = rrd.rows("/scene/object/estimate", "strips")
    assert [time for time, *_ in estimates] == pytest.approx([update["time"] for update in stored["updates"]])
    for (_, _, strip), update in zip(estimates, stored["updates"], strict=True):
        wheel = update["model"]["effect"][0]
        centre = np.array(strip[0])[:4, :2].mean(axis=0)
        np.testing.assert_allclose(centre, [wheel["x"], wheel["y"]], atol=1e-6)
    _, distance = rrd.array("/plots/distance/to_the_goal", "scalars")
    assert distance.tolist() == [row["distance"] for row in stored["steps"]]
    _, pushed = rrd.array("/plots/torque/measured", "scalars")
    assert pushed.tolist() == [row["wrench"][2] for row in stored["steps"]]
    assert "episode_00" in rrd.only("/summary", "text")[0]


def test_the_readings_of_a_recording_are_used(recording: trundle.Recording, tmp_path: Path) -> None:
    folder = written(tmp_path / "run")
    one = {"episode_00": recording.episodes["episode_00"]}
    metadata = {key: value for key, value in recording.metadata.items() if key != "split"}
    trundle.Recording(metadata, one).write(folder / "episode_00" / "recording")
    rrd = Rrd(trundle.view(folder, tmp_path / "run.rrd"))
    _, force = rrd.array("/recording/force_x", "scalars")
    column = one["episode_00"]["force_x"]
    assert force.tolist() == column[np.isfinite(column)].tolist()


def test_a_damaged_history_is_refused(tmp_path: Path) -> None:
    folder = written(tmp_path / "run")
    (folder / "episode_00" / "history.json").write_text("{")
    with pytest.raises(trundle.TrundleError, match=r"history\.json: is damaged"):
        trundle.view(folder, tmp_path / "run.rrd")
    assert not (tmp_path / "run.rrd").exists()
