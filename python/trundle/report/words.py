"""What people call an effect, and how a share or a number within a sentence is written."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from trundle.report.given import finite
from trundle.report.quantity import listed, readable

__all__ = ["MEASUREMENT", "capitalised", "effect", "effects", "percent", "probability", "sets", "spoken"]

_SPOKEN = {
    "coulomb_friction": "dry friction",
    "directional_friction": "friction that differs between forth and back",
    "caster_swivel": "a caster that swivels",
    "second_wheel": "a second wheel",
    "com_offset": "a mass centre that is elsewhere",
    "floor_slope": "a sloping floor",
    "floor_patch": "a patch of floor that drags",
    "floor_grain": "a floor with a grain",
    "wheel_event": "a wheel that locks or comes free",
    "mass_change": "a change of load",
    "obstacle_contact": "an obstacle",
    "tether": "a tether",
    "swinging_load": "a load that swings",
    "force_bias": "an offset of the force sensor",
    "force_scale": "a wrong gain of the force sensor",
    "latency": "a delay of the force sensor",
    "gripper_inertia": "the gripper's own mass in the reading",
    "tracker_offset": "an offset of the tracked frame",
    "cogging": "a force that is periodic in the place",
    "quadratic_drag": "drag that grows with the square of the speed",
    "thinning_drag": "drag that grows less than the speed",
    "doorsill": "a doorsill",
    "axis_friction": "dry friction along axes of the room",
    "body_axis_friction": "dry friction along axes of the object",
    "cross_talk": "cross-talk of the force sensor",
    "saturation": "saturation of the force sensor",
    "dead_band": "a dead band of the force sensor",
    "sensor_play": "play of the force sensor",
    "sensor_lag": "a lag of the force sensor",
    "clock_drift": "a drift of the clocks",
    "drive_lag": "a lag of the drive",
}

MEASUREMENT = frozenset(
    {
        "force_bias",
        "force_scale",
        "latency",
        "gripper_inertia",
        "tracker_offset",
        "cross_talk",
        "saturation",
        "dead_band",
        "sensor_play",
        "sensor_lag",
        "clock_drift",
    }
)
"""Effects of how it was measured: the object and its floor are as simulated."""


def effect(name: object) -> str:
    """Return an effect's name as people say it; several are joined by `+`."""
    parts = [part.strip() for part in str(name).split("+")]
    return listed([_SPOKEN.get(part, readable(part)) for part in parts])


def effects(names: Iterable[object], last: str = "and") -> str:
    """Return several effects in one phrase."""
    return listed([effect(name) for name in names], last)


def sets(groups: Iterable[Iterable[object]]) -> str:
    """Return whole sets of effects, any of which would do, in one phrase."""
    return listed([effects(group, "with") for group in groups], "or")


def capitalised(text: str) -> str:
    """Return a phrase with its first letter as at the start of a sentence."""
    return f"{text[:1].upper()}{text[1:]}"


def percent(share: float) -> str:
    """Return a share in per cent that never claims to be certain."""
    if share > 0.99:
        return "> 99 %"
    return "< 1 %" if share < 0.01 else f"{100.0 * share:.0f} %"


def probability(entry: Mapping[str, Any]) -> float | None:
    """Return the probability that an entry of diagnosis.json states."""
    return finite(entry.get("probability"))


def spoken(text: object) -> str:
    """Return a sentence from elsewhere with the minus sign and the spacing that the page uses."""
    signed = re.sub(r"(?<![\w.\N{MINUS SIGN}-])-(?=\d)", "\N{MINUS SIGN}", str(text))
    return re.sub(r"(?<=\d) (?=(?:N|m|s|kg|rad|mm|cm|Hz)\b)", "\N{NO-BREAK SPACE}", signed)
