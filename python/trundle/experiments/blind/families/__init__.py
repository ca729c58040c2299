"""Families of hidden effects: those of the catalogue, and those outside it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from trundle.experiments.blind.families.bodies import BODIES
from trundle.experiments.blind.families.out_of_catalogue import FORCES
from trundle.experiments.blind.families.sensing import OUT_OF_CATALOGUE_SENSING, SENSING
from trundle.experiments.blind.families.surroundings import SURROUNDINGS
from trundle.experiments.blind.family import Family

__all__ = ["CATALOGUE", "INDISTINGUISHABLE_PAIRS", "LATER_EFFECTS", "UNKNOWN", "selected"]

ORDER = """
coulomb_friction caster_swivel second_wheel com_offset floor_slope floor_patch floor_grain wheel_event
mass_change obstacle_contact tether swinging_load force_bias force_scale latency gripper_inertia
tracker_offset axis_friction thinning_drag cross_talk saturation dead_band sensor_play clock_drift sensor_lag
"""
"""Order of the effects of the catalogue in benchmarks. The drawn cases depend on it."""


def selected(families: Mapping[str, Family], names: Iterable[str]) -> dict[str, Family]:
    """Return some families in the given order."""
    return {name: families[name] for name in names}


LATER_EFFECTS = ("mass_spread",)
"""Effects that a benchmark must name, because "all" means those of the first benchmarks."""
CATALOGUE = selected({**BODIES, **SURROUNDINGS, **SENSING}, (*ORDER.split(), *LATER_EFFECTS))
"""Effects of the catalogue by name."""
UNKNOWN: Mapping[str, Family] = {**FORCES, **OUT_OF_CATALOGUE_SENSING}
"""Families without a law in the catalogue. The correct answer is "unexplained"."""
INDISTINGUISHABLE_PAIRS = (
    frozenset({"com_offset", "tracker_offset"}),
    frozenset({"second_wheel", "wheel_event"}),
)
"""Pairs of effects that are never hidden together.

In general no push distinguishes the first pair: one motion of one rigid body. The second would hide two
wheels of which one changes; two wheels equal one wheel and a rotational damping only if neither changes.
"""
