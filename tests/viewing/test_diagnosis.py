"""A diagnosis as an .rrd file: simulations, the missing wrench, and windows."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import trundle
from tests.viewing.conftest import MODEL, WINDOW, answer
from tests.viewing.rrd import Rrd
from trundle.cli import main
from trundle.diagnosis import Diagnosis

FRICTION = "/scene/object/missing/coulomb_friction"
POINT = np.array([0.5, -0.3])


@pytest.fixture
def rrd(diagnosis: Path, tmp_path: Path) -> Rrd:
    return Rrd(trundle.view(diagnosis, tmp_path / "table.rrd"))


def test_the_simulated_push_comes_first_with_both_models(rrd: Rrd, predictions: pd.DataFrame) -> None:
    names = [state[0] for _, _, state in rrd.rows("/states/episode", "state")]
    assert names == ["episode_06 (held out)", "", "episode_00", ""]
    for side in ("before", "after"):
        times, translation = rrd.array(f"/scene/{side}", "translation")
        np.testing.assert_allclose(translation[:, 0], predictions[f"{side}_x"], atol=1e-6)
        np.testing.assert_allclose(
            times, predictions["t"] - rrd.array("/recording/t", "scalars", 0)[1][0], atol=1e-6
        )
        _, x = rrd.array(f"/plots/position/x_{side}", "scalars")
        assert x.tolist() == predictions[f"{side}_x"].tolist()
    _, before = rrd.array("/plots/position_residual/before", "scalars")
    _, after = rrd.array("/plots/position_residual/after", "scalars")
    np.testing.assert_allclose(before, 0.1, atol=1e-9)
    np.testing.assert_allclose(after, 0.01, atol=1e-9)
    cleared = [time for time, episode, _ in rrd.rows("/scene", "is_recursive") if episode == 1]
    assert len(cleared) == 1, "simulations do not stay during a push without any"


def test_wheels_are_those_of_each_model(rrd: Rrd) -> None:
    for path, centre in (("before", [-0.25, 0.125]), ("after", [-0.5, 0.3]), ("object", [-0.5, 0.3])):
        strip = np.array(rrd.rows(f"/scene/{path}/wheels", "strips")[0][2][0])
        np.testing.assert_allclose(strip[:4, :2].mean(axis=0), centre, atol=1e-6)


def test_the_missing_wrench_is_that_of_the_law(recording: trundle.Recording, rrd: Rrd) -> None:
    motion = trundle.smooth(recording)["episode_06"]
    _, torque = rrd.array("/plots/torque/dry_friction", "scalars", 0)
    force = np.column_stack(
        [rrd.array(f"/plots/force/{axis}_dry_friction", "scalars", 0)[1] for axis in ("x", "y")]
    )
    np.testing.assert_allclose(torque, POINT[0] * force[:, 1] - POINT[1] * force[:, 0], atol=1e-9)
    cos, sin = np.cos(motion["pose"][:, 2]), np.sin(motion["pose"][:, 2])
    vx, vy, spin = motion["twist"].T
    slip = np.column_stack([cos * vx + sin * vy - spin * POINT[1], cos * vy - sin * vx + spin * POINT[0]])
    speed = np.linalg.norm(slip, axis=1)
    moving = speed > 0.02
    assert moving.sum() > 100
    np.testing.assert_allclose(force[moving], -14.0 * slip[moving] / speed[moving, None], atol=0.01)
    _, vectors = rrd.array(FRICTION, "vectors", 0)
    _, measured = rrd.array("/scene/object/measured", "vectors", 0)
    push = trundle.prepare(recording)["episode_06"]["on_object"][:, :2]
    scale = np.linalg.norm(measured) / np.linalg.norm(push)
    np.testing.assert_allclose(vectors[:, :2], force * scale, atol=1e-4)
    _, origins = rrd.array(FRICTION, "origins", 0)
    np.testing.assert_allclose(origins[:, :2], np.tile(POINT, (len(origins), 1)), atol=1e-6)


def test_windows_and_the_verdict_are_shown(rrd: Rrd) -> None:
    begin = rrd.array("/recording/t", "scalars", 1)[0][0]
    windows = [(time, state[0]) for time, _, state in rrd.rows("/states/mismatch", "state")]
    assert [state for _, state in windows] == ["mismatch", ""]
    assert [time for time, _ in windows] == pytest.approx([begin + WINDOW["start"], begin + WINDOW["end"]])
    text = rrd.only("/summary", "text")[0]
    assert "Dry friction is missing" in text
    assert "0.36 m before, 0.004 m after" in text


def test_a_diagnosis_in_memory_has_the_missing_wrench_of_every_push(
    recording: trundle.Recording, tmp_path: Path
) -> None:
    t = np.linspace(0.0, 1.0, 5)
    prepared = trundle.prepare(recording)
    wrench = np.arange(15.0).reshape(5, 3)
    episodes = [
        {
            "name": name,
            "t": each["pose_t"],
            "observed": each["pose"],
            "before": each["pose"] + [0.2, 0.0, 0.0],
            "after": None,
            "residual": {"t": t, "before": wrench},
        }
        for name, each in prepared.items()
    ]
    changed: dict[str, Any] = {**answer(), "verdict": "unexplained", "missing": []}
    model = trundle.Model.from_toml(MODEL.partition('[[effect]]\nkind = "coulomb')[0])
    found = Diagnosis(changed, model, "", {"episodes": episodes}, None)  # type: ignore[arg-type]
    with pytest.raises(trundle.TrundleError, match="does not contain its recording: pass `recording`"):
        trundle.view(found, tmp_path / "a.rrd")
    rrd = Rrd(trundle.view(found, tmp_path / "a.rrd", recording=recording))
    for index in (0, 1):
        _, residual = rrd.array("/plots/force_residual/y_before", "scalars", index)
        assert residual.tolist() == wrench[:, 1].tolist()
        _, error = rrd.array("/plots/position_residual/before", "scalars", index)
        np.testing.assert_allclose(error, 0.2, atol=1e-9)
    _, origins = rrd.array("/scene/object/missing/residual", "origins")
    np.testing.assert_allclose(origins[:, :2], np.tile(POINT, (10, 1)), atol=1e-6)
    _, arrows = rrd.array("/scene/object/missing/residual", "vectors")
    forces = np.tile(wrench[:, :2], (2, 1))
    np.testing.assert_allclose(arrows[:, :2] / arrows[-1, 1], forces / forces[-1, 1], atol=1e-5)
    assert arrows[-1, 1] > 0.0
    assert "/scene/after" not in rrd.entities


def test_a_lost_recording_is_named_with_a_remedy(
    diagnosis: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    elsewhere = tmp_path / "archive" / "2026" / "table"
    elsewhere.parent.mkdir(parents=True)
    (tmp_path / "recordings" / "table").rename(elsewhere)
    assert main(["view", str(diagnosis)]) == 2
    assert "'office table'" in (said := capsys.readouterr().err)
    assert "--recording" in said
    assert not diagnosis.with_name("table.rrd").exists()
    assert main(["view", str(diagnosis), "--recording", str(elsewhere)]) == 0
    assert diagnosis.with_name("table.rrd").exists()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"name": "another table"},
            "the diagnosis is of the recording 'office table', not of 'another table'",
        ),
        ({"episodes": {"episode_06": "episode_05"}}, "has no episode_06, which the diagnosis simulates"),
        ({"moved": 0.001}, "episode_06: its poses differ from those in the diagnosis"),
    ],
)
def test_another_recording_is_refused(
    change: dict[str, Any], said: str, recording: trundle.Recording, diagnosis: Path, tmp_path: Path
) -> None:
    names = change.get("episodes", {})
    episodes = {
        names.get(name, name): {**table, "object_x": table["object_x"] + change.get("moved", 0.0)}
        for name, table in recording.episodes.items()
    }
    split = {"held_out": [list(episodes)[-1]]}
    metadata = {**recording.metadata, "name": change.get("name", recording.name), "split": split}
    other = trundle.Recording(metadata, episodes)
    with pytest.raises(trundle.TrundleError, match=said):
        trundle.view(diagnosis, tmp_path / "a.rrd", recording=other)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "diagnosis.json: is damaged"),
        (json.dumps({"format": "x"}), "`format` = 'x'; this trundle reads"),
    ],
)
def test_a_damaged_answer_is_refused(text: str, said: str, diagnosis: Path, tmp_path: Path) -> None:
    (diagnosis / "diagnosis.json").write_text(text)
    with pytest.raises(trundle.TrundleError, match=said):
        trundle.view(diagnosis, tmp_path / "a.rrd")
