"""Files of a patch, refusals, and the command."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest

from tests.export.patching import ROBOT, effect, model, patched
from trundle import TrundleError
from trundle.cli import main
from trundle.export import write_mjcf_patch
from trundle.mechanism import MechanismModel, MechanismTable, Posterior
from trundle.settings import parse


def test_ranges_respect_bounds(tmp_path: Path) -> None:
    described = model(effect("joint_dry_friction", effort=0.1), damping__elbow=0.5)
    names = ["damping:elbow", "joint_dry_friction:elbow.effort"]
    posterior = Posterior(names, [0.5, 0.1], [[0.01, 0.0], [0.0, 0.04]])
    described = MechanismModel(described.mechanism, described.nominal, described.effect, posterior)
    folder = patched(tmp_path, described)
    table = parse(folder / "randomisation.toml")
    assert [one["name"] for one in table["parameter"]] == names
    assert table["parameter"][0]["low"] == pytest.approx(0.5 - 1.96 * 0.1, abs=1e-4)
    assert (table["parameter"][1]["low"], table["parameter"][1]["sd"]) == (0.0, pytest.approx(0.2))
    assert MechanismModel.read(folder / "model.toml") == described
    assert sorted(path.name for path in folder.iterdir()) == ["model.toml", "randomisation.toml", "robot.xml"]


def test_files_of_the_original_are_found_from_the_new_folder(tmp_path: Path) -> None:
    mesh = '<asset><mesh name="part" file="part.obj"/><mesh name="gone" file="gone.obj"/></asset>'
    geoms = '<geom type="mesh" mesh="part" mass="0"/><geom type="mesh" mesh="gone" mass="0"/>'
    text = ROBOT.replace("<worldbody>", f"{mesh}<worldbody>{geoms}")
    (tmp_path / "source").mkdir()
    faces = "f 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n"
    (tmp_path / "source" / "part.obj").write_text(f"v 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nv 0 0 0\n{faces}")
    folder = patched(tmp_path, model(), text)
    assert mujoco.MjModel.from_xml_path(str(folder / "robot.xml")).nmesh == 1
    assert "missing files are removed: gone.obj" in (folder / "robot.xml").read_text()


@pytest.mark.parametrize(
    ("described", "message"),
    [
        (
            model(effect("joint_dry_friction", "wrist", effort=1.0)),
            "unknown joint 'wrist'; the recorded joints are",
        ),
        (model(effect("joint_dry_friction")), "joint_dry_friction:elbow: `effort` is missing"),
        (model(effect("rust", amount=1.0)), "kind = 'rust': unknown; known are encoder_offset"),
        (model(mas__lower=1.0), "'mas:lower': unknown value; known are armature, damping, mass"),
        (model(effect("payload", "hand", mass=1.0)), "payload:hand: the model has no such body"),
        (
            model(effect("joint_backlash", gap=0.1), armature__elbow=0.0),
            "'elbow' has no armature, which is the inertia of the drive",
        ),
    ],
)
def test_refusals(described: MechanismModel, message: str, tmp_path: Path) -> None:
    with pytest.raises(TrundleError, match=message):
        patched(tmp_path, described)
    assert not (tmp_path / "exports").exists()


def test_an_axis_cannot_be_patched(tmp_path: Path) -> None:
    MechanismModel(MechanismTable(["arm"], axis="hinge")).write(tmp_path / "model.toml")
    with pytest.raises(TrundleError, match="an axis without an MJCF file cannot be patched"):
        write_mjcf_patch(tmp_path / "model.toml", tmp_path / "patched")


def test_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("robot.xml").write_text(ROBOT)
    Path("diagnosis").mkdir()
    described = model(effect("joint_dry_friction", effort=0.6), effect("effort_delay", delay=0.01))
    described.write("diagnosis/model.toml")
    line = ["export", "diagnosis/model.toml", "--mjcf-patch", "patched"]
    assert main(line) == 2
    assert "robot.xml: no such file; give the MJCF or URDF file with --mjcf FILE" in capsys.readouterr().err
    assert main([*line, "--mjcf", "robot.xml"]) == 0
    names = ("model.toml", "randomisation.toml", "robot.xml")
    assert capsys.readouterr().out.split() == [f"patched/{name}" for name in names]
    assert "effort_delay:elbow is a property of the recorded effort" in Path("patched/robot.xml").read_text()
    for arguments, message in (
        (["--mujoco", "--mjcf", "robot.xml"], "--mjcf robot.xml: applies only to --mjcf-patch"),
        (["--mjcf-patch", "other", "--out", "more"], "--mjcf-patch other: --out and --footprint apply only"),
    ):
        assert main(["export", "diagnosis/model.toml", *arguments]) == 2
        assert message in capsys.readouterr().err
