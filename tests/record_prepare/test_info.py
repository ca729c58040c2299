"""`trundle info`, `trundle check` and the picture."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import trundle
from tests.record_prepare.table import MASS, NOISE, Table, metadata, recording, tables
from trundle.cli import main


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    table = Table(episodes=3, metadata={"split": {"held_out": ["episode_02"]}})
    path = tmp_path_factory.mktemp("recordings") / "table"
    recording(table).write(path)
    return path


def test_the_statistics_agree_with_the_table(folder: Path) -> None:
    info = trundle.inspect(folder)
    assert info.noise.pose == pytest.approx(NOISE["pose"], rel=0.15)
    assert info.noise.force == pytest.approx(NOISE["force"], rel=0.1)
    assert info.noise.torque == pytest.approx(NOISE["torque"], rel=0.1)
    assert not info.noise.stated
    assert 0.3 * MASS < info.mass < 5 * MASS
    assert [episode.held_out for episode in info.episodes] == [False, False, True]
    for episode in info.episodes:
        assert episode.object.rate == pytest.approx(1000 / 17)
        assert episode.wrench.rate == pytest.approx(100.0)
        assert episode.counts.pose_outliers == 0
        assert 0.5 < episode.contact < 0.75
        assert 10.0 < episode.peak_force < 60.0
        assert episode.travel[0] > 0.1


def test_drop_outs_are_counted() -> None:
    table = Table(episodes=1)
    described, episodes = metadata(table), tables(table)
    columns = episodes["episode_00"]
    lost = (columns["t"] > 2.0) & (columns["t"] < 2.5)
    for name in columns:
        if name.startswith("object"):
            columns[name][lost] = float("nan")
    [episode] = trundle.inspect(trundle.Recording(described, episodes)).episodes
    assert (episode.object.gaps, episode.counts.pose_gaps) == (1, 1)
    assert episode.object.longest_gap > 0.5
    assert episode.counts.stale_pose > 30


def test_info_prints_a_table_or_json(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(folder)]) == 0
    text = capsys.readouterr().out
    assert "3 episodes, 1 held out" in text and "episode_02  held out" in text
    assert main(["info", str(folder), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads(json.dumps(trundle.inspect(folder).to_dict()))


@pytest.mark.parametrize("kind", ["png", "svg"])
def test_the_figure_is_drawn(folder: Path, kind: str, tmp_path: Path) -> None:
    picture = tmp_path / f"table.{kind}"
    assert main(["info", str(folder), "--picture", str(picture)]) == 0
    head = picture.read_bytes()[:400]
    assert (b"\x89PNG" if kind == "png" else b"<svg") in head


def test_an_unknown_image_format_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(folder), "--picture", "table.doc"]) == 2
    assert ".svg" in capsys.readouterr().err
    assert not Path("table.doc").exists()


def test_check_prints_findings_with_remedies(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", str(folder), "--strict"]) == 0
    assert "nothing found" in capsys.readouterr().out
    table = Table(episodes=2)
    described = metadata(table)
    described["wrench"]["sign"] = "on_object"
    wrong = tmp_path / "wrong"
    trundle.Recording(described, tables(table)).write(wrong)
    assert main(["check", str(wrong)]) == 0
    text = capsys.readouterr().out
    assert "error (sign)" in text and "→" in text
    assert main(["check", str(wrong), "--json", "--strict"]) == 2
    assert json.loads(capsys.readouterr().out)[0]["kind"] == "sign"
