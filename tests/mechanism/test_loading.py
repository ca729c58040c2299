"""Models become mechanisms of their recorded joints, or are refused with a reason."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.mechanism.models import ARM, JOINTS, motion
from trundle import TrundleError
from trundle.mechanism import Mechanism, Payload, touching_bodies

BODY = '<body name="{0}"><joint name="{0}_joint" axis="0 1 0"/><geom size="0.1"/>{1}</body>'
PAIR = BODY.format("a", BODY.format("b", "{inner}"))

URDF = """<robot name="r">
<link name="base"/>
<link name="arm"><inertial><origin xyz="0 0 0.1"/><mass value="1"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  <visual><geometry><mesh filename="package://robot/arm.dae"/></geometry></visual>
  <collision><geometry><mesh filename="package://robot/arm.stl"/></geometry></collision></link>
<link name="tool"><inertial><mass value="0.2"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="claw"><inertial><mass value="0.1"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="elbow" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
  <limit lower="-1" upper="2" effort="10" velocity="1"/><dynamics damping="0.3" friction="0.2"/></joint>
<joint name="flange" type="fixed"><parent link="arm"/><child link="tool"/><origin xyz="0 0 0.3"/></joint>
<joint name="grip" type="continuous"><parent link="tool"/><child link="claw"/><axis xyz="0 1 0"/>
  <mimic joint="elbow" multiplier="2" offset="0.1"/></joint>
</robot>"""


def model(bodies: str, rest: str = "") -> str:
    return f"<mujoco><worldbody>{bodies}</worldbody>{rest}</mujoco>"


def test_properties() -> None:
    arm = Mechanism.load(ARM, JOINTS)
    assert arm.joints == ("lift", "shoulder", "roll", "finger")
    assert arm.followers == ("mimic",)
    assert arm.bodies == ("upper", "rail", "left", "right")
    assert arm.masses == pytest.approx({"upper": 2.3, "rail": 1.05, "left": 0.1, "right": 0.12})
    assert arm.damping.tolist() == [2.0, 0.3, 0.0, 0.0]
    assert arm.frictionloss.tolist() == [0.0, 0.4, 0.0, 0.0]
    assert arm.stiffness.tolist() == [0.0, 1.5, 0.0, 0.0]
    assert np.isinf(arm.ranges).all()
    assert [arm.rigid_group(body) for body in ("wedge", "hand", "rail")] == ["upper", "rail", "rail"]
    with pytest.raises(TrundleError, match="'base' does not move; the moving bodies are upper, rail"):
        arm.rigid_group("base")


def test_a_singular_inertia_becomes_the_nearest_valid_one() -> None:
    def inertia(stated: str) -> NDArray[np.float64]:
        old = '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>'
        arm = Mechanism.load(URDF.replace(old, f"<inertia {stated}/>", 1), ["elbow"])
        return np.array(arm.compiled.body("arm").inertia)

    rod = inertia('ixx="0.03" iyy="0.03" izz="0" ixy="0" ixz="0" iyz="0"')
    np.testing.assert_allclose(sorted(rod), [0.0, 0.03, 0.03], atol=1e-6)
    ones = inertia('ixx="0.01" iyy="0.01" izz="0.01" ixy="0.01" ixz="0.01" iyz="0.01"')
    np.testing.assert_allclose(sorted(ones), [0.015, 0.015, 0.03], atol=1e-6)
    with pytest.raises(TrundleError, match=r"positive eigenvalues.*'arm'.*correct the mass and inertia of"):
        inertia('ixx="0.01" iyy="0.01" izz="-0.01" ixy="0" ixz="0" iyz="0"')


def test_locked_joints_keep_the_pose_of_the_reference() -> None:
    full = mujoco.MjModel.from_xml_string(ARM)
    expected = mujoco.MjData(full)
    mujoco.mj_kinematics(full, expected)
    for joints in (JOINTS, ["roll"], ["finger", "locked"]):
        arm = Mechanism.load(ARM, joints)
        data = mujoco.MjData(arm.compiled)
        mujoco.mj_kinematics(arm.compiled, data)
        for k in range(full.nbody):
            name = full.body(k).name
            np.testing.assert_allclose(data.body(name).xpos, expected.body(name).xpos, atol=1e-12)
            np.testing.assert_allclose(data.body(name).xquat, expected.body(name).xquat, atol=1e-12)


def test_a_follower_moves_exactly_and_does_work_at_its_driver() -> None:
    """Virtual work of an independent model in which both joints are free."""
    arm = Mechanism.load(ARM.replace('frictionloss="0.02"', ""), JOINTS)
    free = Mechanism.load(
        ARM.replace('frictionloss="0.02"', "").replace("<equality>", "<!--").replace("</equality>", "-->"),
        [*JOINTS, "mimic"],
    )
    q, v, a = motion()
    x, dx = q[:, 3], v[:, 3]
    slope = 3 + 4 * x
    follower = [0.3 + 0.05 + 3 * x + 2 * x**2, slope * dx, slope * a[:, 3] + 4 * dx**2]
    apart = free.inverse_dynamics(*(np.column_stack(each) for each in zip((q, v, a), follower, strict=True)))
    together = arm.inverse_dynamics(q, v, a)
    np.testing.assert_allclose(together[:, :3], apart[:, :3], atol=1e-11)
    np.testing.assert_allclose(together[:, 3], apart[:, 3] + slope * apart[:, 4], atol=1e-11)


def test_a_driver_may_be_recorded_by_its_follower() -> None:
    tie = '<equality><joint joint1="a_joint" joint2="b_joint" polycoef="0.1 2 0 0 0"/></equality>'
    text = model(PAIR.format(inner=""), tie)
    q = np.array([[0.4]])
    by_driver = Mechanism.load(text, ["b_joint"]).coordinates.expand(q, q, q)
    by_follower = Mechanism.load(text, ["a_joint"]).coordinates.expand(0.1 + 2 * q, 2 * q, 2 * q)
    np.testing.assert_allclose(by_driver[:3], by_follower[:3], atol=1e-12)


def test_urdf_needs_no_meshes_and_keeps_the_names_of_fixed_links(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(URDF)
    for source in (path, URDF):
        arm = Mechanism.load(source, ["elbow"], payload=Payload("tool", 0.5))
        assert arm.bodies == ("arm", "claw")
        assert arm.followers == ("grip",)
        assert arm.rigid_group("tool") == "arm"
        assert arm.masses["arm"] == pytest.approx(1.2)
        assert (arm.damping[0], arm.frictionloss[0], arm.ranges[0].tolist()) == (0.3, 0.2, [-1.0, 2.0])
        assert arm.missing_files == ("package://robot/arm.stl",)


MESH = '<asset><mesh name="part" file="part.stl"/><texture name="t" type="2d" file="t.png"/>'
MESH += '<material name="m" texture="t"/></asset>'


def test_missing_meshes_matter_only_for_inertia() -> None:
    geom = '<geom type="mesh" mesh="part" material="m" {0}/>'
    inertial = '<inertial pos="0 0 1" mass="1" diaginertia="1 1 1"/>'
    body = '<body name="arm"><joint name="elbow" axis="0 1 0"/>{0}</body>'
    for inner in (geom.format("") + inertial, geom.format('density="0"') + '<geom size="0.1"/>'):
        arm = Mechanism.load(model(body.format(inner), MESH), ["elbow"])
        assert arm.missing_files == ("part.stl",)
    base = '<body name="base">' + geom.format("") + body.format(inertial) + "</body>"
    assert Mechanism.load(model(base, MESH), ["elbow"]).masses == {"arm": 1.0}
    with pytest.raises(
        TrundleError, match=r"body 'arm': its inertia comes from the mesh 'part\.stl'.*<inertial>"
    ):
        Mechanism.load(model(body.format(geom.format("")), MESH), ["elbow"])
    with pytest.raises(TrundleError, match="inertia comes from the mesh"):
        text = model(body.format(geom.format("") + inertial), MESH + '<compiler inertiafromgeom="true"/>')
        Mechanism.load(text, ["elbow"])


def test_inertia_from_an_existing_mesh(tmp_path: Path) -> None:
    text = model(
        '<body name="arm"><joint name="elbow"/><geom type="mesh" mesh="part" contype="0"/></body>',
        '<asset><mesh name="part" file="part.obj"/></asset>',
    )
    faces = "f 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n"
    (tmp_path / "part.obj").write_text(f"v 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nv 0 0 0\n{faces}")
    (tmp_path / "robot.xml").write_text(text)
    arm = Mechanism.load(tmp_path / "robot.xml", ["elbow"])
    assert arm.masses["arm"] == pytest.approx(1000 * 0.1**3 / 6)
    assert arm.missing_files == ()


def test_a_locked_parent_does_not_collide_with_its_child() -> None:
    """MuJoCo ignores contacts between parent and child only while the parent moves."""
    arm = Mechanism.load(model(PAIR.format(inner="")), ["b_joint"])
    mujoco.mj_forward(arm.compiled, arm.data)
    assert arm.data.ncon == 0
    base = '<body name="base"><geom size="0.1"/>' + BODY.format("arm", "") + "</body>"
    touching = Mechanism.load(model(base), ["arm_joint"])
    mujoco.mj_forward(touching.compiled, touching.data)
    assert touching.data.ncon == 1
    at_rest = [np.zeros((2, 1))] * 3
    assert touching.regressors(*at_rest).contacts.tolist() == [1, 1]
    assert arm.regressors(*at_rest).contacts.tolist() == [0, 0]
    assert touching_bodies(touching, [[0.0], [0.1]]) == {("base", "arm"): 1.0}
    assert touching_bodies(arm, [[0.0]]) == {}
    apart = Mechanism.load(model(base), ["arm_joint"], contacts=False)
    assert apart.regressors(*at_rest).contacts.tolist() == [0, 0]


def test_limits_and_contacts_are_a_part_of_the_effort() -> None:
    joint = '<joint name="j" type="slide" axis="0 0 1" {0}/>'
    body = f'<body name="arm">{joint}<geom size="0.1" pos="0 0 0.09"/></body>'
    floor = '<geom type="plane" size="1 1 1"/>'
    at_rest = [np.zeros((1, 1))] * 3
    free = Mechanism.load(model(body.format("")), ["j"]).regressors(*at_rest)
    assert free.constraint[0, 0] == 0.0
    limited = Mechanism.load(model(body.format('range="0.01 1" limited="true"')), ["j"])
    standing = Mechanism.load(model(floor + body.format("")), ["j"])
    for held in (limited.regressors(*at_rest), standing.regressors(*at_rest)):
        assert held.constraint[0, 0] < -1.0
        np.testing.assert_allclose(held.effort - held.constraint, free.effort)


FREE = '<body name="box"><freejoint/><geom size="0.1"/></body>'
BALL = '<body name="box"><joint name="wrist" type="ball"/><geom size="0.1"/></body>'
TENDON = (
    '<tendon><fixed name="cable" {0}><joint joint="a_joint" coef="1"/>'
    '<joint joint="b_joint" coef="1"/></fixed></tendon>'
)


@pytest.mark.parametrize(
    ("text", "joints", "message"),
    [
        (model(PAIR), ["a_jont"], "unknown joint 'a_jont'; did you mean 'a_joint'"),
        (model(PAIR), [], r"joints = \[\]: name at least one of 'a_joint', 'b_joint'"),
        (model(PAIR), ["a_joint", "a_joint"], "'a_joint' is named twice"),
        (
            model(PAIR + FREE),
            ["a_joint"],
            "its joint without a name is a free joint.*attach the base",
        ),
        (model(PAIR + BALL), ["a_joint"], "'wrist' is a ball joint.*three hinges"),
        (model(PAIR, TENDON.format('stiffness="3"')), ["a_joint"], "tendon 'cable' couples.*'b_joint'"),
        (
            model(PAIR, '<equality><connect body1="b" body2="world" anchor="0 0 0"/></equality>'),
            ["a_joint"],
            "between bodies 'b' and 'world' closes a loop",
        ),
        (
            model(PAIR, '<equality><joint joint1="a_joint" joint2="b_joint"/></equality>'),
            ["a_joint", "b_joint"],
            "'a_joint' and 'b_joint' are coupled.*record only one",
        ),
        (
            model(PAIR, '<equality><joint joint1="a_joint"/></equality>'),
            ["a_joint"],
            "an equality constraint holds it",
        ),
        (
            model(
                PAIR, '<equality><joint joint1="a_joint" joint2="b_joint" polycoef="0 0 1 0 0"/></equality>'
            ),
            ["a_joint"],
            "record 'b_joint' instead",
        ),
        (
            model(PAIR, TENDON.format("") + '<equality><tendon tendon1="cable"/></equality>'),
            ["a_joint", "b_joint"],
            "tendon 'cable' couples recorded joints",
        ),
        ("<mujoco><nonsense/></mujoco>", ["a_joint"], "not a model that MuJoCo can read: .*nonsense"),
        (model('<body><joint name="j"/></body>'), ["j"], "MuJoCo cannot compile.*mass and inertia"),
        ("no_such_robot.xml", ["j"], "no_such_robot.xml: no such file"),
    ],
)
def test_refusals(text: str, joints: list[str], message: str) -> None:
    with pytest.raises(TrundleError, match=message):
        Mechanism.load(text.replace("{inner}", ""), joints)


def test_options_that_inverse_dynamics_cannot_use_are_reset() -> None:
    plain = Mechanism.load(ARM, JOINTS).inverse_dynamics(*motion())
    option = '<option gravity="0.3 -0.2 -9.7">'
    discrete = ARM.replace(
        option[:-1] + "/>", option + '<flag invdiscrete="enable" sleep="enable"/></option>'
    )
    np.testing.assert_array_equal(Mechanism.load(discrete, JOINTS).inverse_dynamics(*motion()), plain)
    without = ARM.replace(option[:-1] + "/>", option + '<flag gravity="disable"/></option>')
    found = Mechanism.load(without, JOINTS).regressors(*motion())
    fallen = found.effort + found.gravity @ [0.3, -0.2, -9.7]
    np.testing.assert_allclose(fallen, plain, atol=1e-11)


def test_an_old_version_of_mujoco_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mujoco, "__version__", "3.9.1")
    with pytest.raises(TrundleError, match=r"need mujoco 3\.14 or newer, not 3\.9\.1: pip install --upgrade"):
        Mechanism.load(ARM, JOINTS)


def test_constraints_and_tendons_without_effect_on_recorded_joints_are_removed() -> None:
    rest = TENDON.format("") + '<equality><connect body1="a" body2="b" anchor="0 0 0"/></equality>'
    mocap = '<body name="target" mocap="true"/>'
    weld = '<equality><weld body1="b" body2="target"/></equality>'
    arm = Mechanism.load(model(PAIR.format(inner="") + mocap, rest + weld), ["a_joint"])
    assert (arm.compiled.neq, arm.compiled.ntendon) == (0, 0)
    kept = Mechanism.load(
        model(PAIR.format(inner=""), TENDON.format('stiffness="3"')), ["a_joint", "b_joint"]
    )
    q = np.array([[0.2, 0.3]])
    spring = kept.inverse_dynamics(q, 0 * q, 0 * q)
    free = Mechanism.load(model(PAIR.format(inner="")), ["a_joint", "b_joint"]).inverse_dynamics(
        q, 0 * q, 0 * q
    )
    np.testing.assert_allclose(spring - free, 3 * 0.5, atol=1e-9)


def test_gravity_compensation_by_a_drive_is_part_of_the_effort() -> None:
    body = '<body name="arm" {0}><joint name="elbow" axis="0 1 0" {1}/><geom size="0.1" pos="1 0 0"/></body>'
    at_rest = [np.zeros((1, 1))] * 3
    plain, passive, active = (
        Mechanism.load(model(body.format(*each)), ["elbow"])
        for each in (("", ""), ('gravcomp="1"', ""), ('gravcomp="1"', 'actuatorgravcomp="true"'))
    )
    assert passive.inverse_dynamics(*at_rest)[0, 0] == pytest.approx(0.0, abs=1e-9)
    weight = plain.inverse_dynamics(*at_rest)
    np.testing.assert_allclose(active.inverse_dynamics(*at_rest), weight)
    for arm, expected in ((plain, 1.0), (passive, 0.0), (active, 1.0)):
        per_mass = arm.regressors(*at_rest).mass["arm"]
        np.testing.assert_allclose(per_mass * arm.masses["arm"], expected * weight, atol=1e-9)


@pytest.mark.parametrize(
    ("q", "message"),
    [
        ([[0.0, 1.0]], r"q: shape \(1, 2\).*4 columns"),
        ([[0.0, np.nan, 0, 0]], "q: row 0, joint 'shoulder': nan"),
    ],
)
def test_motions_are_checked(q: list[list[float]], message: str) -> None:
    arm = Mechanism.load(ARM, JOINTS)
    with pytest.raises(TrundleError, match=message):
        arm.inverse_dynamics(q, [[0.0] * 4], [[0.0] * 4])
    with pytest.raises(TrundleError, match="'nobody' is not in the model"):
        arm.adjusted(mass={"nobody": 1.0})
    with pytest.raises(TrundleError, match="joint 'mimic' is not recorded"):
        arm.adjusted(damping={"mimic": 1.0})
    with pytest.raises(TrundleError, match="payload: body 'base' is unknown or does not move"):
        Mechanism.load(ARM, JOINTS, payload=Payload("base", 1.0))
    with pytest.raises(TrundleError, match="joint 'mimic' is not recorded"):
        arm.effort_with_offset([[0.0] * 4], [[0.0] * 4], [[0.0] * 4], "mimic", 0.1)
