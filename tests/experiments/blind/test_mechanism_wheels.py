"""Robots of packages, read from a wheel that the test writes."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

import trundle

pytest.importorskip("mujoco")

from trundle.experiments.blind.mechanism import wheels
from trundle.experiments.blind.mechanism.wheels import WheelRobot, read_robots, robots_of
from trundle.experiments.blind.settings import read
from trundle.mechanism import Mechanism

CONFIG = Path(__file__).parents[3] / "configs/experiments/mechanism.toml"
LINK = """<inertial pos="0.1 0.02 -0.1" quat="0.9 0.1 0.3 0.2" mass="{}" diaginertia="0.02 0.018 0.009"/>
<geom type="mesh" mesh="shape"/>"""
ROBOT = f"""<mujoco><compiler angle="radian"/><asset><mesh name="shape" file="meshes/shape.stl"/></asset>
<worldbody><body name="base" pos="0.1 0.2 0.3" euler="0.3 0.1 -0.4"><geom size="0.1"/>
<body name="upper" pos="0 0.1 0.2" euler="0.2 0 0.3">
<joint name="arm:lift" axis="0 1 1" range="-1 1" damping="2" frictionloss="1"/>{LINK.format(2.0)}
<body name="plate" pos="0.1 0 0" euler="0 0.4 0">{LINK.format(0.3)}</body>
<body name="fore" pos="0 0 0.4" euler="-0.7 0.1 0">
<joint name="arm:slide" type="slide" axis="1 0 0.2" ref="0.1" range="0 0.4" armature="0.8"/>{LINK.format(1.0)}
<body name="hand" pos="0.1 0 0"><joint name="grip" axis="0 0 1"/>{LINK.format(0.2)}</body></body></body>
</body></worldbody><actuator><motor joint="arm:lift"/></actuator></mujoco>"""
SOURCE = WheelRobot("maker", "maker/assets/robot.xml", ("arm:lift", "arm:slide"))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    with zipfile.ZipFile(tmp_path / "maker-1.0-py3-none-any.whl", "w") as wheel:
        wheel.writestr("maker/assets/robot.xml", ROBOT)
    return tmp_path


def test_the_chain_needs_the_same_efforts_as_the_file(folder: Path, tmp_path: Path) -> None:
    robot = wheels.read_robot(folder, "maker_arm", SOURCE)
    assert robot.joints == ("lift", "slide")
    assert robot.spans["lift"] == pytest.approx((-0.6, 0.6))
    assert robot.spans["slide"] == pytest.approx((0.08, 0.32))
    assert robot.masses == pytest.approx({"lift_link": 2.3, "slide_link": 1.2})
    (tmp_path / "robot.xml").write_text(ROBOT, encoding="utf-8")
    original = Mechanism.load(tmp_path / "robot.xml", SOURCE.joints)
    chain = Mechanism.load(robot.text, robot.joints)
    q, v, a = np.random.default_rng(0).uniform(-0.5, 0.5, (3, 20, 2))
    q = 0.2 + 0.2 * q  # between the limits
    efforts = [
        one.inverse_dynamics(q, v, a) - one.frictionloss * np.sign(v) - one.damping * v - one.armature * a
        for one in (original, chain)
    ]
    assert np.allclose(efforts[0], efforts[1], atol=1e-6)
    assert (chain.frictionloss == 0).all() and (chain.damping > 0).all()
    # The file's armature stays; a joint without one gets a rotor.
    assert chain.armature[1] == pytest.approx(0.8) and chain.armature[0] > 0


def test_missing_wheels_files_and_chains_are_named(folder: Path) -> None:
    for source, words in (
        (WheelRobot("other", SOURCE.path, SOURCE.joints), "pip download .* other"),
        (WheelRobot("maker", "maker/none.xml", SOURCE.joints), "has no file maker/none.xml"),
        (WheelRobot("maker", SOURCE.path, ("arm:slide", "arm:lift")), "one behind the other"),
        (WheelRobot("maker", SOURCE.path, ("wrist",)), "unknown joint 'wrist'"),
    ):
        with pytest.raises(trundle.TrundleError, match=words):
            wheels.read_robot(folder, "robot", source)


def test_the_settings_choose_the_sets(tmp_path: Path) -> None:
    own = read(CONFIG, "smoke")
    assert own.robots == ("own",) and "robots" not in own.drawing() and "robots" not in own.plain()
    text = CONFIG.read_text(encoding="utf-8")
    path = tmp_path / "mechanism.toml"
    path.write_text(text.replace('robots = ["own"]', 'robots = ["own", "wheels"]'), encoding="utf-8")
    both = read(path, "smoke")
    assert both.drawing()["robots"] == both.plain()["robots"] == ["own", "wheels"]
    path.write_text(text.replace('robots = ["own"]', 'robots = ["mine"]'), encoding="utf-8")
    with pytest.raises(trundle.TrundleError, match="choose from own, wheels"):
        read(path, "smoke")
    names = [robot.name for robot in robots_of(["own"])]
    assert "scara" in names
    with pytest.raises(trundle.TrundleError, match="no wheel of robosuite"):
        read_robots(tmp_path)
