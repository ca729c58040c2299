"""Names of effects in the report, and the typesetting of shares and sentences."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from trundle.report.quantity import join_words, key_to_words
from trundle.report.series import finite

__all__ = [
    "INSTRUMENT_EFFECTS",
    "capitalise",
    "drawn_note",
    "effect_name",
    "effect_names",
    "effect_sets",
    "format_percent",
    "format_share",
    "probability_of",
    "typeset",
]

_EFFECT_NAMES = {
    "coulomb_friction": "dry friction",
    "directional_friction": "friction that depends on the direction of motion",
    "caster_swivel": "a swivelling caster",
    "second_wheel": "a second wheel",
    "com_offset": "an offset of the mass centre",
    "mass_spread": "an inertia that is not that of a uniform body",
    "floor_slope": "a sloping floor",
    "floor_patch": "a floor patch with drag",
    "floor_grain": "a floor with a grain",
    "wheel_event": "a wheel that locks or unlocks",
    "mass_change": "a change of load",
    "obstacle_contact": "an obstacle",
    "tether": "a tether",
    "swinging_load": "a swinging load",
    "force_bias": "an offset of the force sensor",
    "force_scale": "a wrong gain of the force sensor",
    "latency": "a delay of the force sensor",
    "gripper_inertia": "the gripper's own mass in the reading",
    "tracker_offset": "an offset of the tracked frame",
    "cogging": "a force that is periodic in position",
    "quadratic_drag": "drag that is quadratic in speed",
    "thinning_drag": "drag that is sublinear in speed",
    "doorsill": "a doorsill",
    "axis_friction": "dry friction along world axes",
    "body_axis_friction": "dry friction along object axes",
    "cross_talk": "cross-talk of the force sensor",
    "saturation": "saturation of the force sensor",
    "dead_band": "a dead band of the force sensor",
    "sensor_play": "backlash of the force sensor",
    "sensor_lag": "a lag of the force sensor",
    "clock_drift": "a drift of the clocks",
    "drive_lag": "a lag of the drive",
}

INSTRUMENT_EFFECTS = frozenset(
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
"""Effects of the sensor, the tracker and the clocks rather than of the object and the floor."""


def effect_name(name: object) -> str:
    """Return the name of an effect in the report; `effect` may be several, joined by `+`."""
    parts = [part.strip() for part in str(name).split("+")]
    return join_words([_EFFECT_NAMES.get(part, key_to_words(part)) for part in parts])


def effect_names(names: Iterable[object], last: str = "and") -> str:
    """Return the names of several effects as a list with `last` before the last one."""
    return join_words([effect_name(name) for name in names], last)


def effect_sets(groups: Iterable[Iterable[object]]) -> str:
    """Return alternative sets of effects as a list with "or"."""
    return join_words([effect_names(group, "with") for group in groups], "or")


def capitalise(text: str) -> str:
    """Return a phrase with an upper-case first letter."""
    return f"{text[:1].upper()}{text[1:]}"


def drawn_note(shown: int, total: int) -> str:
    """Return a note on how many episodes are drawn; an empty string if all are."""
    return "" if shown == total else f"{shown} of {total} episodes are shown."


def format_percent(share: float) -> str:
    """Format a share in per cent, clipped to "> 99 %" and "< 1 %"."""
    if share > 0.99:
        return "> 99 %"
    return "< 1 %" if share < 0.01 else f"{100.0 * share:.0f} %"


def format_share(value: object) -> str:
    """Format a share in per cent; an absent one is an empty string."""
    share = finite(value)
    return "" if share is None else format_percent(share)


def explained_by_effect(value: object) -> tuple[str, str] | None:
    """Return the share of the held-out misfit that an effect explains, and the rest of the sentence.

    `explains` of diagnosis.json is negative if the effect increases the misfit. None if it is absent.
    """
    share = finite(value)
    if share is None:
        return None
    if share < 0.0:
        return format_percent(-share), "larger misfit on held-out data with this effect"
    return format_percent(share), "of the misfit on held-out data is explained by this effect"


def probability_of(entry: Mapping[str, Any]) -> float | None:
    """Return the probability of an entry of diagnosis.json; None if it has none."""
    return finite(entry.get("probability"))


def typeset(text: object) -> str:
    """Return a sentence with typographic minus signs and with no-break spaces before units."""
    signed = re.sub(r"(?<![\w.\N{MINUS SIGN}-])-(?=\d)", "\N{MINUS SIGN}", str(text))
    return re.sub(r"(?<=\d) (?=(?:N|m|s|kg|rad|mm|cm|Hz)\b)", "\N{NO-BREAK SPACE}", signed)
