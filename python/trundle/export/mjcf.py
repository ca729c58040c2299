"""Conversion of a model to MJCF: the planar body, and the actuators through which its effects act."""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from typing import Any

from trundle._native import Laws, Model, TrundleError
from trundle.export.shape import Point, convex_pieces

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["mjcf", "parse_model"]

BODY_HEIGHT_M = 0.2
"""Height of the body, m. Only its appearance and contacts depend on it."""
TIMESTEP_S = 0.002
ACTUATOR_DIRECTIONS = {
    "push_x": (1, 0, 0),
    "push_y": (0, 1, 0),
    "push_theta": (0, 0, 1),
    "damping_x": (1, 0, 0),
    "damping_y": (0, 1, 0),
    "damping_theta": (0, 0, 1),
    "damping_xy": (1, 1, 0),
    "damping_xtheta": (1, 0, 1),
    "damping_ytheta": (0, 1, 1),
}
"""Direction (x, y, theta) at the object's origin along which an actuator pushes or damps."""


def mjcf(model: Model, footprint: Sequence[Sequence[float]] | None = None) -> str:
    """Return the MJCF of a model.

    Parameters
    ----------
    model : Model
        Must contain a value for every parameter.
    footprint : sequence of (x, y), optional
        Corners, m, for a model without a footprint.

    Raises
    ------
    TrundleError
        If neither the model nor the caller gives a footprint, or a parameter has no value.
    """
    text = parse_model(model)
    shapes = fixtures(text["body"], footprint)
    laws = Laws(model)
    root = ET.Element("mujoco", model="trundle")
    ET.SubElement(root, "option", timestep=f"{TIMESTEP_S}", integrator="implicitfast")
    if laws.starts:
        # States of effects, such as the angle of a caster. MuJoCo stores them with its state.
        ET.SubElement(root, "size", nuserdata=str(len(laws.starts)))
    ET.SubElement(root, "visual").append(ET.Element("global", offwidth="1280", offheight="960"))
    assets, world = ET.SubElement(root, "asset"), ET.SubElement(root, "worldbody")
    add_scene(assets, world)
    add_body(assets, world, laws, shapes)
    add_marks(world[-1], text.get("effect", []))
    add_actuators(ET.SubElement(root, "actuator"))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def parse_model(model: Model) -> dict[str, Any]:
    """Return the content of a model's `model.toml`."""
    return tomllib.loads(model.to_toml())


def fixtures(body: Mapping[str, Any], footprint: Sequence[Sequence[float]] | None) -> list[dict[str, Any]]:
    """Return the polygons and discs of the caller's footprint or else of the model."""
    if footprint is not None:
        return [{"polygon": footprint}]
    if "footprint" in body:
        return [{"polygon": body["footprint"]}]
    if not body.get("fixture"):
        raise TrundleError(
            "the model has no footprint: give --footprint '[[x, y], ...]' (metres, object frame)"
        )
    return list(body["fixture"])


def add_scene(assets: ET.Element, world: ET.Element) -> None:
    """Add a light and a floor without contacts."""
    ET.SubElement(
        assets,
        "texture",
        name="floor",
        type="2d",
        builtin="checker",
        rgb1=".9 .9 .9",
        rgb2=".8 .8 .8",
        width="300",
        height="300",
    )
    ET.SubElement(assets, "material", name="floor", texture="floor", texrepeat="20 20")
    ET.SubElement(world, "light", pos="0 0 4", dir="0 0 -1", diffuse=".8 .8 .8")
    looks = {"contype": "0", "conaffinity": "0", "material": "floor"}
    ET.SubElement(world, "geom", looks, name="floor", type="plane", size="10 10 .1")


def add_body(assets: ET.Element, world: ET.Element, laws: Laws, shapes: Sequence[Mapping[str, Any]]) -> None:
    """Add the body with its joints, inertia and geoms."""
    body = ET.SubElement(world, "body", name="object")
    for name, kind, axis in (("x", "slide", "1 0 0"), ("y", "slide", "0 1 0"), ("theta", "hinge", "0 0 1")):
        ET.SubElement(body, "joint", name=f"object_{name}", type=kind, axis=axis)
    # In the plane only the inertia about the vertical matters.
    inertia = format_numbers([laws.inertia] * 3)
    # The mass centre must not be at the origin: MuJoCo would treat the body as simple and drop the couplings
    # between directions from the derivatives of forces.
    ET.SubElement(
        body,
        "inertial",
        pos=format_numbers([*laws.com, BODY_HEIGHT_M / 2]),
        mass=f"{laws.mass!r}",
        diaginertia=inertia,
    )
    ET.SubElement(body, "site", name="object", size="0.02", rgba=".2 .2 .2 1")
    number = 0
    for shape in shapes:
        for attributes in geoms(shape):
            number += 1
            if "vertex" in attributes:
                ET.SubElement(assets, "mesh", name=f"object_{number}", vertex=attributes.pop("vertex"))
                attributes |= {"type": "mesh", "mesh": f"object_{number}"}
            ET.SubElement(body, "geom", attributes, name=f"object_{number}", rgba=".55 .65 .8 1")


def geoms(shape: Mapping[str, Any]) -> list[dict[str, str]]:
    """Return attributes of the geoms of one fixture: cylinders, boxes, or prisms by their vertices."""
    middle = BODY_HEIGHT_M / 2 + 0.01
    if "disc" in shape:
        x, y, radius = shape["disc"]
        return [
            {
                "type": "cylinder",
                "size": format_numbers([radius, BODY_HEIGHT_M / 2]),
                "pos": format_numbers([x, y, middle]),
            }
        ]
    corners: list[Point] = [(float(x), float(y)) for x, y in shape["polygon"]]
    xs, ys = sorted({x for x, _ in corners}), sorted({y for _, y in corners})
    if len(corners) == 4 and len(xs) == len(ys) == 2:
        size = [(xs[1] - xs[0]) / 2, (ys[1] - ys[0]) / 2, BODY_HEIGHT_M / 2]
        pos = [(xs[1] + xs[0]) / 2, (ys[1] + ys[0]) / 2, middle]
        return [{"type": "box", "size": format_numbers(size), "pos": format_numbers(pos)}]
    ends = (middle - BODY_HEIGHT_M / 2, middle + BODY_HEIGHT_M / 2)
    prisms = [
        [coordinate for z in ends for x, y in piece for coordinate in (x, y, z)]
        for piece in convex_pieces(corners)
    ]
    return [{"vertex": format_numbers(prism)} for prism in prisms]


def add_marks(body: ET.Element, effects: Sequence[Mapping[str, Any]]) -> None:
    """Mark the positions of effects by sites without physics."""
    for number, effect in enumerate(effects, 1):
        if {"x", "y"} <= effect.keys():
            name = f"object_{effect['kind']}_{number}"
            pos = format_numbers([effect["x"], effect["y"], BODY_HEIGHT_M + 0.02])
            ET.SubElement(body, "site", name=name, pos=pos, size="0.03", rgba=".85 .3 .2 1")


def add_actuators(actuators: ET.Element) -> None:
    """Add the actuators of the callback: pushes, controlled by force, and dampers, controlled by damping.

    The gain of a damper is minus the velocity, so MuJoCo's implicit integrators have its force derivative.
    """
    for name, (x, y, theta) in ACTUATOR_DIRECTIONS.items():
        gain = {"gaintype": "fixed", "gainprm": "1"}
        if name.startswith("damping"):
            gain = {"gaintype": "affine", "gainprm": "0 0 -1"}
        gear = format_numbers([x, y, 0, 0, 0, theta])
        ET.SubElement(actuators, "general", gain, name=f"object_{name}", site="object", gear=gear)


def format_numbers(values: Sequence[float]) -> str:
    """Format numbers for MJCF with full precision."""
    return " ".join(f"{float(value)!r}" for value in values)
