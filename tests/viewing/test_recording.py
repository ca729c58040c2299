"""A recording as an .rrd file: every value, the scene, and the timelines."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle
from tests.viewing.conftest import seen
from tests.viewing.rrd import Rrd
from trundle.cli import main
from trundle.viewing import viewer


@pytest.fixture(scope="module")
def rrd(recording: trundle.Recording, tmp_path_factory: pytest.TempPathFactory) -> Rrd:
    return Rrd(trundle.view(recording, tmp_path_factory.mktemp("view") / "table.rrd"))


def test_every_cell_of_the_recording_is_stored(recording: trundle.Recording, rrd: Rrd) -> None:
    for index, table in enumerate(recording.episodes.values()):
        for name, column in table.items():
            times, values = rrd.array(f"/recording/{name}", "scalars", index)
            assert values.tolist() == seen(column).tolist(), name
            expected = table["t"][np.isfinite(column)] - table["t"][0]
            np.testing.assert_allclose(times - np.floor(times[0]), expected, atol=2e-6)


def test_episodes_follow_each_other_on_one_timeline(recording: trundle.Recording, rrd: Rrd) -> None:
    first, _ = rrd.array("/recording/t", "scalars", 0)
    second, _ = rrd.array("/recording/t", "scalars", 1)
    assert first[0] == 0.0
    assert 1.0 <= second[0] - first[-1] <= 2.0
    assert second[0] == round(second[0])
    names = [(time, state[0]) for time, _, state in rrd.rows("/states/episode", "state")]
    begins = [first[0], first[-1], second[0], second[-1]]
    assert [name for _, name in names] == ["episode_00", "", "episode_06 (held out)", ""]
    assert [time for time, _ in names] == pytest.approx(begins, abs=1e-6)


def test_the_object_moves_as_recorded(recording: trundle.Recording, rrd: Rrd) -> None:
    prepared = trundle.prepare(recording)
    for index, name in enumerate(recording.episodes):
        pose = prepared[name]["pose"]
        _, translation = rrd.array("/scene/object", "translation", index)
        np.testing.assert_allclose(translation[:, :2], pose[:, :2], atol=1e-6)
        _, turn = rrd.array("/scene/object", "quaternion", index)
        gap = 2.0 * np.arctan2(turn[:, 2], turn[:, 3]) - pose[:, 2]
        assert np.abs(np.sin(gap / 2.0)).max() < 1e-6
    outline = rrd.rows("/scene/object/outline", "strips")[0][2][0]
    np.testing.assert_allclose(
        np.array(outline)[:4, :2], recording.metadata["object"]["footprint"], atol=1e-6
    )
    assert len(rrd.rows("/scene/object/feet", "positions")[0][2]) == 4
    table = recording.episodes["episode_00"]
    _, gripper = rrd.array("/scene/gripper", "translation", 0)
    np.testing.assert_allclose(gripper[:, 0], seen(table["gripper_x"]), atol=1e-6)


def test_the_arrow_is_the_tared_wrench_at_the_sensor(recording: trundle.Recording, rrd: Rrd) -> None:
    push = trundle.prepare(recording)["episode_00"]
    _, vectors = rrd.array("/scene/object/measured", "vectors", 0)
    _, origins = rrd.array("/scene/object/measured", "origins", 0)
    np.testing.assert_allclose(origins[:, :2], push["frame"][:, :2], atol=1e-6)
    force = push["on_object"][:, :2]
    scale = np.linalg.norm(vectors) / np.linalg.norm(force)
    np.testing.assert_allclose(vectors[:, :2], force * scale, atol=1e-5)
    stated = float(rrd.only("/summary", "text")[0].split("1 m is a force of ")[1].split(" N")[0])
    assert stated == pytest.approx(1.0 / scale, rel=0.01)
    for k, axis in enumerate(("x_measured", "y_measured")):
        _, plotted = rrd.array(f"/plots/force/{axis}", "scalars", 0)
        assert plotted.tolist() == force[:, k].tolist()
    _, torque = rrd.array("/plots/torque/measured", "scalars", 0)
    assert torque.tolist() == push["on_object"][:, 2].tolist()


def test_contact_is_marked(recording: trundle.Recording, rrd: Rrd) -> None:
    starts = [time for time, _, state in rrd.rows("/states/contact", "state") if state == ["contact"]]
    assert len(starts) == 2
    assert starts[0] == pytest.approx(trundle.prepare(recording)["episode_00"]["contact"], abs=1e-6)


def test_the_same_input_gives_the_same_rows(recording: trundle.Recording, tmp_path: Path) -> None:
    first, second = (Rrd(trundle.view(recording, tmp_path / name)) for name in ("a.rrd", "b.rrd"))
    assert first.contents() == second.contents()


def test_an_object_on_a_rail(tmp_path: Path) -> None:
    t = np.arange(200) * 0.01
    table = {"t": t, "object_x": 0.1 * np.sin(t), "force_x": np.cos(t)}
    metadata = {
        "format": "trundle-recording/1",
        "name": "axis",
        "object": {"dof": ["x"]},
        "wrench": {"frame": "world", "sign": "on_object"},
    }
    rrd = Rrd(trundle.view(trundle.Recording(metadata, {"run": table}), tmp_path / "axis.rrd"))
    _, translation = rrd.array("/scene/object", "translation")
    np.testing.assert_allclose(translation[:, 0], table["object_x"], atol=1e-6)
    assert "/scene/gripper" not in rrd.entities
    assert rrd.rows("/scene/object/outline", "strips")


def test_the_command_writes_next_to_the_recording(
    recording: trundle.Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recording.write(tmp_path / "table")
    assert main(["view", str(tmp_path / "table")]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'table.rrd'}\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["table", "table.rrd"]
    assert main(["view", str(tmp_path / "table")]) == 0, "an earlier file is replaced"


def test_the_viewer_opens_only_where_there_is_a_display(
    recording: trundle.Recording,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    recording.write(tmp_path / "table")
    line = ["view", str(tmp_path / "table"), "--open"]
    started: list[Any] = []
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(
        "trundle.viewing.viewer.subprocess.Popen", lambda command, **_: started.append(command)
    )
    for name in viewer.DISPLAYS:
        monkeypatch.delenv(name, raising=False)
    assert main(line) == 2
    assert "--open: this machine has no display" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["table"]
    monkeypatch.setenv("DISPLAY", ":0")
    assert main(line) == 0
    assert started == [[sys.executable, "-m", "rerun", str(tmp_path / "table.rrd")]]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["empty"], "empty: is neither a recording (a folder with recording.toml), a diagnosis"),
        (
            ["table", "--out", "table.bag"],
            "table.bag: unknown suffix '.bag'; a Rerun recording is written as .rrd",
        ),
        (["table", "--out", "notes.rrd"], "notes.rrd: exists and is not a Rerun recording"),
        (["table", "--out", "folder.rrd"], "folder.rrd: is a folder"),
        (["table", "--recording", "table"], "table: is not a diagnosis; only a diagnosis takes --recording"),
        (["run"], "run: no episode is finished"),
    ],
)
def test_unusable_input_is_refused(
    arguments: list[str],
    said: str,
    recording: trundle.Recording,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    recording.write("table")
    for folder in ("empty", "folder.rrd", "run"):
        Path(folder).mkdir()
    Path("run/settings.json").write_text("{}")
    Path("notes.rrd").write_text("my notes")
    before = sorted(tmp_path.rglob("*"))
    assert main(["view", *arguments]) == 2
    assert said in capsys.readouterr().err
    assert sorted(tmp_path.rglob("*")) == before
    assert Path("notes.rrd").read_text() == "my notes"


def test_a_missing_package_is_named(
    recording: trundle.Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(trundle.TrundleError, match=r"need rerun: pip install 'trundle\[rerun\]'"):
        trundle.view(recording, tmp_path / "table.rrd")
    assert list(tmp_path.iterdir()) == []


def test_rerun_is_imported_only_on_use() -> None:
    code = "import sys, trundle; assert callable(trundle.view); assert 'rerun' not in sys.modules"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
