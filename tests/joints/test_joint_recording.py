"""Recordings of joints in Python: construction, mapping, files, refusals by functions for pushed objects."""

from __future__ import annotations

import copy
import pickle
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle
from tests.command import trundle as command
from tests.joints.simulated import Columns, recording
from trundle import viewing
from trundle.export.mcap import write_mcap

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MODEL = '<mujoco><include file="arm.xml"/></mujoco>'


@pytest.fixture
def columns() -> Columns:
    t = np.arange(0.0, 1.0, 0.01)
    q = np.sin(t)
    q[3] = np.nan
    return {"t": t, "q_elbow": q, "effort_elbow": np.cos(t), "q_shoulder": 2.0 * t}


@pytest.fixture
def arm(columns: Columns) -> trundle.JointRecording:
    metadata = {
        "format": "trundle-recording/2",
        "name": "arm",
        "mechanism": {"model": "robot.xml", "joints": ["shoulder", "elbow"]},
        "effort": {"gain": {"elbow": "free"}},
        "split": {"held_out": ["b"]},
    }
    files: dict[str, str | bytes] = {"robot.xml": MODEL, "arm.xml": b"<mujocoinclude/>"}
    return trundle.JointRecording(metadata, {"a": columns, "b": columns}, files)


@pytest.mark.parametrize("table", ["csv", "parquet"])
def test_a_recording_is_read_as_written(arm: trundle.JointRecording, table: Any, tmp_path: Path) -> None:
    arm.write(tmp_path / "run", table)
    again = trundle.read(tmp_path / "run")
    assert isinstance(again, trundle.JointRecording)
    assert again == arm
    assert again.files == {"robot.xml": MODEL.encode(), "arm.xml": b"<mujocoinclude/>"}
    assert (tmp_path / "run" / "robot.xml").read_text() == MODEL


def test_a_recording_is_a_mapping_of_episodes(arm: trundle.JointRecording, columns: Columns) -> None:
    assert (len(arm), list(arm), "a" in arm, "c" in arm) == (2, ["a", "b"], True, False)
    assert arm.joints == ["shoulder", "elbow"]
    assert [name for name, episode in arm.items() if episode.held_out] == ["b"]
    assert arm["a"] == arm.episodes["a"] != arm["b"]
    assert list(arm["a"]) == ["t", "q_elbow", "q_shoulder", "effort_elbow"]
    np.testing.assert_array_equal(arm["a"]["q_elbow"], columns["q_elbow"])
    t, q = arm["a"].stream("q", "elbow")
    assert len(t) == len(q) == 99
    assert arm["a"].streams == {"shoulder": ("q",), "elbow": ("q", "effort")}
    assert trundle.JointRecording(arm.metadata, arm, arm.files) == arm
    assert copy.deepcopy(arm) == pickle.loads(pickle.dumps(arm)) == arm
    with pytest.raises(trundle.TrundleError, match="there is no column v_elbow; the columns are: q_elbow"):
        arm["a"].stream("v", "elbow")
    with pytest.raises(trundle.TrundleError, match="no episode of arm"):
        arm["c"]


def test_data_frames_are_accepted_and_returned(arm: trundle.JointRecording) -> None:
    frames = {name: arm.frame(name) for name in arm}
    assert trundle.JointRecording(arm.metadata, frames, arm.files) == arm


def test_representations(arm: trundle.JointRecording) -> None:
    assert "<trundle.JointRecording 'arm': 2 episodes>" in repr(arm)
    assert "model robot.xml" in repr(arm)
    assert "trundle.JointEpisode" in repr(arm["a"])
    assert "<table" in arm._repr_html_()
    assert "trundle.JointSummary 'arm'" in repr(trundle.inspect(arm))


def test_the_summary_has_rates_ranges_and_speeds(arm: trundle.JointRecording, tmp_path: Path) -> None:
    arm.write(tmp_path / "run")
    summary = trundle.inspect(tmp_path / "run")
    assert isinstance(summary, trundle.JointSummary)
    shoulder, elbow = summary.episodes[0].joints
    assert elbow.streams["q"].samples == 99
    assert elbow.streams["effort"].rate == pytest.approx(100.0)
    assert shoulder.position_range == pytest.approx((0.0, 1.98))
    assert shoulder.peak_speed == pytest.approx(2.0, rel=1e-6)
    assert (shoulder.effort_range, summary.joints[0].stated) == (None, False)
    ran = command(tmp_path, "info", "run")
    assert ran.returncode == 0, ran.stderr
    assert "model robot.xml" in ran.stdout
    assert "elbow" in ran.stdout


REFUSING: dict[str, Callable[[Any], object]] = {
    "fit": trundle.fit,
    "sample": trundle.sample,
    "prepare": trundle.prepare,
    "smooth": trundle.smooth,
    "profile": lambda recording: trundle.profile(recording, "body.mass"),
    "view": lambda recording: viewing.view(recording, "out.rrd"),
    "plots": lambda recording: trundle.plots.recording(recording),
    "mcap": lambda recording: write_mcap(recording, Path("out.mcap")),
}


@pytest.mark.parametrize("function", REFUSING)
def test_functions_for_pushed_objects_refuse_joints(
    function: str, arm: trundle.JointRecording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    arm.write("run")
    for given in (arm, "run"):
        with pytest.raises(trundle.TrundleError, match=r"recordings? of joints"):
            REFUSING[function](given)
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


@pytest.mark.parametrize("verb", ["fit", "sample"])
def test_verbs_for_pushed_objects_refuse_joints(
    verb: str, arm: trundle.JointRecording, tmp_path: Path
) -> None:
    arm.write(tmp_path / "run")
    ran = command(tmp_path, verb, "run")
    assert ran.returncode == 2
    assert "of joints" in ran.stderr
    assert "Traceback" not in ran.stderr


def test_a_pushed_object_is_refused_as_joints() -> None:
    with pytest.raises(trundle.TrundleError, match="is the format of recordings of pushed objects"):
        trundle.JointRecording({"format": "trundle-recording/1"}, {})


def test_files_must_be_text_or_bytes(columns: Columns) -> None:
    with pytest.raises(trundle.TrundleError, match="content of the document as str or bytes"):
        trundle.JointRecording(recording([columns]).metadata, {"a": columns}, {"arm.xml": 1})  # type: ignore[dict-item]


def test_the_example_of_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "joint-recordings.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    (document,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(compile(code, "joint-recordings.md", "exec"), names)
    assert len(names["times"]) == len(names["positions"]) == 1200
    assert capsys.readouterr().out == "", "the recording of the example has no findings"
    # The document of the page is valid, with the episodes that it names.
    columns = {"t": [0.0, 0.1], "q_shoulder": [0.0, 0.1], "q_elbow": [0.0, 0.1]}
    episodes = dict.fromkeys(("heavy_01", "episode_06"), columns)
    made = trundle.JointRecording(tomllib.loads(document), episodes, {"robot.xml": "<mujoco/>"})
    assert made.metadata["episode"]["heavy_01"]["payload"]["mass"] == 0.5
