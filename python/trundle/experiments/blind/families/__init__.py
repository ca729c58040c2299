"""Families of hidden effects: those of the catalogue, and those outside it."""

from __future__ import annotations

from trundle.experiments.blind.families.casters import CasterSwivel
from trundle.experiments.blind.families.distortion import DISTORTIONS
from trundle.experiments.blind.families.floor import FloorGrain, FloorPatch, FloorSlope
from trundle.experiments.blind.families.friction import CoulombFriction
from trundle.experiments.blind.families.inertia import ComOffset, MassChange, SwingingLoad
from trundle.experiments.blind.families.joints import AxisFriction, ThinningDrag
from trundle.experiments.blind.families.out_of_catalogue_motion import MOTIONS
from trundle.experiments.blind.families.out_of_catalogue_sensing import SENSINGS
from trundle.experiments.blind.families.sensing import (
    ForceBias,
    ForceScale,
    GripperInertia,
    Latency,
    TrackerOffset,
)
from trundle.experiments.blind.families.surroundings import ObstacleContact, Tether
from trundle.experiments.blind.families.wheels import SecondWheel, WheelEvent
from trundle.experiments.blind.family import Family

__all__ = ["CATALOGUE", "FAMILIES", "OUT_OF_CATALOGUE"]

CATALOGUE_FAMILIES: tuple[Family, ...] = (
    CoulombFriction(),
    CasterSwivel(),
    SecondWheel(),
    ComOffset(),
    FloorSlope(),
    FloorPatch(),
    FloorGrain(),
    WheelEvent(),
    MassChange(),
    ObstacleContact(),
    Tether(),
    SwingingLoad(),
    ForceBias(),
    ForceScale(),
    Latency(),
    GripperInertia(),
    TrackerOffset(),
    AxisFriction(),
    ThinningDrag(),
    *DISTORTIONS,
)
CATALOGUE: dict[str, Family] = {family.name: family for family in CATALOGUE_FAMILIES}
"""Effects of the catalogue by name, in the order of docs/diagnosis.md."""
OUT_OF_CATALOGUE: dict[str, Family] = {family.name: family for family in (*MOTIONS, *SENSINGS)}
"""Families without a law in the catalogue. The correct answer is "unexplained"."""
FAMILIES: dict[str, Family] = {**CATALOGUE, **OUT_OF_CATALOGUE}
