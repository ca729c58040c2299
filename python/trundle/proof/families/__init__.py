"""Everything that can be hidden in a recording: the effects of the catalogue, and families outside it."""

from __future__ import annotations

from trundle.proof.families.floor import FloorSlope
from trundle.proof.families.foreign_motion import MOTIONS
from trundle.proof.families.foreign_sensing import SENSINGS
from trundle.proof.families.friction import CoulombFriction
from trundle.proof.families.sensing import ForceBias, Latency
from trundle.proof.families.wheels import SecondWheel, WheelEvent
from trundle.proof.family import Family

__all__ = ["CATALOGUE", "FAMILIES", "FOREIGN"]

CATALOGUE: dict[str, Family] = {
    family.name: family
    for family in (CoulombFriction(), SecondWheel(), FloorSlope(), WheelEvent(), ForceBias(), Latency())
}
"""By the catalogue's name."""
FOREIGN: dict[str, Family] = {family.name: family for family in (*MOTIONS, *SENSINGS)}
"""What no effect of the catalogue is; the right answer is "unexplained"."""
FAMILIES: dict[str, Family] = {**CATALOGUE, **FOREIGN}
