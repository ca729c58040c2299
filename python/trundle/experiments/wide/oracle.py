"""Whether hidden effects are material with the case's own instrument: nominal and true model, both refitted.

The fits see the recording in one convention, the sensor's axes and origin, so that the published convention
does not decide whether a case is material.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import trundle
from trundle.experiments.blind.family import HiddenEffect
from trundle.experiments.blind.oracle import fit_misfit, nominal_misfit, true_laws
from trundle.experiments.blind.readings import Readings
from trundle.experiments.blind.scene import Wheel
from trundle.experiments.wide.measurement import make_recording
from trundle.experiments.wide.scene import WideScene

__all__ = ["oracle_misfits", "rejection_reason"]


def oracle_misfits(
    scene: WideScene,
    hidden: Sequence[HiddenEffect],
    seen: Sequence[Readings],
    bare: Sequence[Readings],
    matters: float,
) -> dict[str, Any]:
    """Return held-out misfits: of the nominal model, of the true model, and without one law at a time.

    Out of the catalogue there is no true law. The reference ("floor") is then the nominal misfit on the same
    scene without the effect.
    """
    scene = in_sensor_convention(scene)
    made = make_recording(scene, hidden, seen, "oracle")
    before = nominal_misfit(made, scene)
    if any(one.family.out_of_catalogue for one in hidden):
        return {"before": before, "floor": nominal_misfit(make_recording(scene, [], bare, "bare"), scene)}
    after = oracle_misfit(made, scene, hidden)
    found: dict[str, Any] = {"before": before, "after": after}
    if len(hidden) > 1 and after is not None and before >= matters * after:
        rest = [[other for other in hidden if other is not one] for one in hidden]
        found["without"] = [oracle_misfit(made, scene, others) for others in rest]
    return found


def in_sensor_convention(scene: WideScene) -> WideScene:
    """Return the scene with the same instrument, published in the sensor's axes about its origin."""
    instrument: Any = scene.instrument
    return replace(
        scene, instrument=replace(instrument, frame="sensor", reference="sensor", sign="on_object")
    )


def oracle_misfit(made: trundle.Recording, scene: WideScene, hidden: Sequence[HiddenEffect]) -> float | None:
    """Return the held-out misfit of the true model, refitted from the truth; None if an effect has no law."""
    laws = true_laws(scene, hidden)
    if laws is None:
        return None
    second = [Wheel(**one.values) for one in hidden if one.family.name == "second_wheel"]
    return fit_misfit(made, replace(scene, wheel=merge_wheels(scene.wheel, second)), laws)


def merge_wheels(wheel: Wheel, others: Sequence[Wheel]) -> Wheel:
    """Return the one wheel that is equivalent to several, except for a rotational damping."""
    if not others:
        return wheel
    whole: NDArray[np.float64] = sum((other.damping() for other in others), wheel.damping())
    lever = np.linalg.solve(whole[:2, :2], whole[:2, 2])
    size, axes = np.linalg.eigh(whole[:2, :2])
    angle = float(np.arctan2(axes[1, 0], axes[0, 0]))
    return Wheel(float(lever[1]), float(-lever[0]), angle, float(size[0]), float(size[1]))


def rejection_reason(oracle: dict[str, Any], matters: float, each_matters: float) -> str | None:
    """Return the reason why a case is not material, or None."""
    before, after = oracle["before"], oracle.get("after", oracle.get("floor"))
    if after is None or not math.isfinite(before) or not math.isfinite(after):
        return "no fit"
    if before < matters * after:
        return "too small"
    if any(one is None or one < each_matters * after for one in oracle.get("without", [])):
        return "one too small"
    return None
