"""Robots and benches of the benchmark: small MJCF texts with masses and lengths of published machines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import mujoco

__all__ = ["ROBOTS", "Robot"]


@dataclass(frozen=True)
class Robot:
    """A mechanism.

    Attributes
    ----------
    name : str
    text : str
        MJCF with armature and damping of every joint, without actuators.
    spans : mapping of str to (low, high)
        By joint: the positions between which it moves, rad or m.
    """

    name: str
    text: str
    spans: Mapping[str, tuple[float, float]]

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints, from the base on."""
        return tuple(self.spans)

    @cached_property
    def masses(self) -> dict[str, float]:
        """Masses of the moving bodies by name, kg."""
        model = mujoco.MjModel.from_xml_string(self.text)
        moving = [k for k in range(1, model.nbody) if model.body_weldid[k] != 0]
        return {model.body(k).name: float(model.body_mass[k]) for k in moving}

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the moving bodies."""
        return tuple(self.masses)


Link = tuple[str, str, str, str, float, str, float, str]
"""Joint, its type and axis, place, mass of its body, centre, radius of gyration, further attributes."""


def chain(name: str, links: Sequence[Link], spans: Sequence[tuple[float, float]]) -> Robot:
    """Return a serial chain; the body of joint JOINT is JOINT_link."""
    text = ""
    for joint, kind, axis, place, mass, centre, gyration, more in links:
        inertia = f"{mass * gyration**2:.6g}"
        slim = f"{0.3 * mass * gyration**2:.6g}"
        text += (
            f'<body name="{joint}_link" pos="{place}">'
            f'<joint name="{joint}" type="{kind}" axis="{axis}" {more}/>'
            f'<inertial pos="{centre}" mass="{mass:g}" diaginertia="{inertia} {inertia} {slim}"/>'
        )
    text = f"<mujoco><compiler angle='radian'/><worldbody>{text}{'</body>' * len(links)}</worldbody></mujoco>"
    return Robot(name, text, {link[0]: span for link, span in zip(links, spans, strict=True)})


def motor(armature: float, damping: float) -> str:
    """Return the attributes of a joint."""
    return f'armature="{armature:g}" damping="{damping:g}"'


PENDULUM = chain(
    "pendulum",  # a lever on a geared servo, as in the bench of BAM (arXiv 2410.08650)
    [("arm", "hinge", "0 1 0", "0 0 0.5", 0.51, "0 0 -0.15", 0.03, motor(0.005, 0.04))],
    [(-1.5, 1.5)],
)
SLIDE = chain(
    "slide_axis",  # masses of the electro-mechanical positioning system EMPS (Janot et al., 2019)
    [("carriage", "slide", "1 0 0", "0 0 0.1", 75.0, "0 0 0", 0.1, motor(20.0, 200.0))],
    [(-0.12, 0.12)],
)
PLANAR = chain(
    "planar_arm",  # two links in the vertical plane, lengths and masses of a laboratory double pendulum
    [
        ("shoulder", "hinge", "0 1 0", "0 0 1", 1.2, "0 0.01 -0.14", 0.09, motor(0.012, 0.15)),
        ("elbow", "hinge", "0 1 0", "0 0 -0.3", 0.7, "0.01 0 -0.12", 0.08, motor(0.006, 0.08)),
    ],
    [(-1.2, 1.2), (-1.5, 1.5)],
)
SCARA = chain(
    "scara",  # masses and lengths of the class of the Adept Cobra s600
    [
        ("base", "hinge", "0 0 1", "0 0 0.4", 8.0, "0.16 0 0", 0.12, motor(0.4, 3.0)),
        ("arm", "hinge", "0 0 1", "0.325 0 0", 5.5, "0.14 0 0", 0.1, motor(0.15, 1.5)),
        ("quill", "slide", "0 0 1", "0.275 0 0", 1.6, "0 0 -0.1", 0.08, motor(1.2, 25.0)),
    ],
    [(-1.4, 1.4), (-1.6, 1.6), (-0.08, 0.08)],
)
VERTICAL = chain(
    "vertical_arm",  # yaw, shoulder and elbow of the size of a 1 kg table arm
    [
        ("yaw", "hinge", "0 0 1", "0 0 0.1", 1.1, "0 0.01 0.03", 0.05, motor(0.02, 0.2)),
        ("shoulder", "hinge", "0 1 0", "0 0 0.08", 0.95, "0.02 0 0.13", 0.08, motor(0.025, 0.3)),
        ("elbow", "hinge", "0 1 0", "0 0 0.25", 0.6, "0.11 0.01 0.01", 0.07, motor(0.012, 0.12)),
    ],
    [(-1.5, 1.5), (-0.9, 1.1), (-1.2, 1.2)],
)
SIX = chain(
    "six_joint_arm",  # masses and lengths of the UR5e, from its published parameters
    [
        ("shoulder_pan", "hinge", "0 0 1", "0 0 0.163", 3.7, "0 0.02 0.01", 0.06, motor(0.5, 6.0)),
        ("shoulder_lift", "hinge", "0 1 0", "0 0.138 0", 8.39, "0 0 0.213", 0.13, motor(0.5, 6.0)),
        ("elbow", "hinge", "0 1 0", "0 -0.131 0.425", 2.33, "0 0 0.15", 0.12, motor(0.25, 4.0)),
        ("wrist_1", "hinge", "0 1 0", "0 0 0.392", 1.22, "0 0.12 0", 0.05, motor(0.1, 1.0)),
        ("wrist_2", "hinge", "0 0 1", "0 0.127 0", 1.22, "0.01 0 0.1", 0.05, motor(0.08, 0.8)),
        ("wrist_3", "hinge", "0 1 0", "0 0 0.1", 0.45, "0.02 0.09 0.01", 0.03, motor(0.05, 0.5)),
    ],
    [(-1.2, 1.2), (-1.0, 0.8), (-1.3, 1.3), (-1.4, 1.4), (-1.4, 1.4), (-1.5, 1.5)],
)
CART_POLE = chain(
    "cart_pole",  # masses of a laboratory cart and pendulum; the pole has a motor of its own
    [
        ("cart", "slide", "1 0 0", "0 0 0.5", 1.1, "0 0 0", 0.05, motor(0.4, 3.0)),
        ("pole", "hinge", "0 1 0", "0 0 0", 0.35, "0.01 0 -0.25", 0.12, motor(0.004, 0.02)),
    ],
    [(-0.25, 0.25), (-1.0, 1.0)],
)
GANTRY = chain(
    "gantry",  # two slides and a hinged tool
    [
        ("bridge", "slide", "1 0 0", "0 0 1", 14.0, "0 0 0", 0.1, motor(4.0, 40.0)),
        ("lift", "slide", "0 0 1", "0 0 0", 6.0, "0 0 0", 0.1, motor(2.5, 30.0)),
        ("tool", "hinge", "0 1 0", "0 0.1 0", 2.0, "0.08 0 -0.1", 0.06, motor(0.03, 0.3)),
    ],
    [(-0.3, 0.3), (-0.2, 0.2), (-1.5, 1.5)],
)
ROBOTS = {one.name: one for one in (PENDULUM, SLIDE, PLANAR, SCARA, VERTICAL, SIX, CART_POLE, GANTRY)}
"""The built-in robots by name."""
