"""Model files of mechanisms survive reading and writing, and are checked."""

from __future__ import annotations

from pathlib import Path

import pytest

from trundle import TrundleError
from trundle.mechanism import MechanismModel

TEXT = """format = "trundle-model/2"

[mechanism]
joints = ["shoulder", "elbow"]
model = "robot.xml"

[nominal]
"armature:elbow" = 0.012
"mass:forearm" = 2

[[effect]]
kind = "joint_dry_friction"
joint = "elbow"
effort = 1.2

[[effect]]
kind = "payload"
body = "forearm"
mass = 0.3
com_x = 0.1

[[effect]]
kind = "base_tilt"
angle_x = 0.1

[posterior]
names = ["armature:elbow", "joint_dry_friction:elbow.effort"]
mean = [0.012, 1.2]
covariance = [[1e-6, 0.0], [0.0, 0.01]]
"""


def test_a_file_survives(tmp_path: Path) -> None:
    model = MechanismModel.from_toml(TEXT)
    assert model.mechanism.joints == ["shoulder", "elbow"]
    assert model.nominal == {"armature:elbow": 0.012, "mass:forearm": 2.0}
    assert [effect.name for effect in model.effect] == [
        "joint_dry_friction:elbow",
        "payload:forearm",
        "base_tilt",
    ]
    assert model.effect[1].parameters == {"mass": 0.3, "com_x": 0.1}
    assert model.posterior is not None
    assert model.posterior.deviations() == pytest.approx(
        {"armature:elbow": 1e-3, "joint_dry_friction:elbow.effort": 0.1}
    )
    model.write(tmp_path / "model.toml")
    assert MechanismModel.read(tmp_path / "model.toml") == model


def test_an_axis_survives() -> None:
    text = 'format = "trundle-model/2"\n[mechanism]\naxis = "hinge"\njoints = ["arm"]\ngravity = true\n'
    model = MechanismModel.from_toml(text + "inertia = 0.5\n")
    assert (model.mechanism.axis, model.mechanism.gravity, model.mechanism.inertia) == ("hinge", True, 0.5)
    assert MechanismModel.from_toml(model.to_toml()) == model


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("model/2", "model/1", 'must begin with format = "trundle-model/2"'),
        ('model = "robot.xml"', "", "give either `model`, an MJCF or URDF file, or `axis`"),
        ('model = "robot.xml"', 'model = "robot.xml"\naxis = "slide"', "either `model`"),
        ('model = "robot.xml"', 'modle = "robot.xml"', "unknown key `mechanism.modle`; did you mean `model`"),
        ("[nominal]", "[nominals]", "unknown key `nominals`; did you mean `nominal`"),
        ("effort = 1.2", "effort = true", "`effect.*parameters.effort` = True"),
        ("effort = 1.2", "effort = inf", "a finite number"),
        ('kind = "payload"', "", "kind` is missing"),
        ("mean = [0.012, 1.2]", "mean = [0.012]", "2 names need 2 means"),
        ("[0.0, 0.01]", "[0.0, -0.01]", "variances must not be negative"),
        ("[mechanism]", "[mechanism", "not a TOML file"),
    ],
)
def test_refusals(old: str, new: str, message: str) -> None:
    assert old in TEXT
    with pytest.raises(TrundleError, match=f"^robot.toml: .*{message}"):
        MechanismModel.from_toml(TEXT.replace(old, new, 1), "robot.toml")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(TrundleError, match=r"absent.toml: no such file"):
        MechanismModel.read(tmp_path / "absent.toml")
