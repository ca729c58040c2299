"""Whether what is hidden matters with the case's own instrument: nominal and true model, both refitted.

The fits see the recording in one convention, the sensor's axes and origin: which convention a case is
published in must not decide whether it counts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import trundle
from trundle.experiments.blind.family import Hidden, Values
from trundle.experiments.blind.oracle import fitted, known_laws, nominal
from trundle.experiments.blind.scene import Wheel
from trundle.experiments.blind.seen import Seen
from trundle.experiments.wide.measure import recorded
from trundle.experiments.wide.scene import WideScene

__all__ = ["reason_to_reject", "weigh"]


def weigh(
    scene: WideScene, hidden: Sequence[Hidden], seen: Sequence[Seen], bare: Sequence[Seen], matters: float
) -> dict[str, Any]:
    """Return held-out misfits: of the nominal model, of the true laws, and with one law left out at a time.

    Out of the catalogue there are no true laws; the same scene without the effect says what a perfect model
    of it would leave ("floor").
    """
    scene = canonical(scene)
    made = recorded(scene, hidden, seen, "oracle")
    before = nominal(made, scene)
    if any(one.family.foreign for one in hidden):
        return {"before": before, "floor": nominal(recorded(scene, [], bare, "bare"), scene)}
    after = with_laws(made, scene, hidden)
    found: dict[str, Any] = {"before": before, "after": after}
    if len(hidden) > 1 and after is not None and before >= matters * after:
        rest = [[other for other in hidden if other is not one] for one in hidden]
        found["without"] = [with_laws(made, scene, others) for others in rest]
    return found


def canonical(scene: WideScene) -> WideScene:
    """Return the scene with the same instrument, published in the sensor's axes about its origin."""
    instrument: Any = scene.instrument
    return replace(
        scene, instrument=replace(instrument, frame="sensor", reference="sensor", sign="on_object")
    )


def with_laws(made: trundle.Recording, scene: WideScene, hidden: Sequence[Hidden]) -> float | None:
    """Return the held-out misfit with true laws, refitted from the truth; None where one has no law yet."""
    laws: list[Values] = []
    for one in hidden:
        found = one.family.laws(scene, one.values)
        if not found or any(law["kind"] not in known_laws() for law in found):
            return None
        laws += found
    second = [Wheel(**one.values) for one in hidden if one.family.name == "second_wheel"]
    return fitted(made, replace(scene, wheel=merged(scene.wheel, second)), laws)


def merged(wheel: Wheel, others: Sequence[Wheel]) -> Wheel:
    """Return the one wheel that does what several do, but for a damping of the spin."""
    if not others:
        return wheel
    whole: NDArray[np.float64] = sum((other.damping() for other in others), wheel.damping())
    lever = np.linalg.solve(whole[:2, :2], whole[:2, 2])
    size, axes = np.linalg.eigh(whole[:2, :2])
    angle = float(np.arctan2(axes[1, 0], axes[0, 0]))
    return Wheel(float(lever[1]), float(-lever[0]), angle, float(size[0]), float(size[1]))


def reason_to_reject(oracle: dict[str, Any], matters: float, each_matters: float) -> str | None:
    """Return why a case does not count, or None."""
    before, after = oracle["before"], oracle.get("after", oracle.get("floor"))
    if after is None or not math.isfinite(before) or not math.isfinite(after):
        return "no fit"
    if before < matters * after:
        return "too small"
    if any(one is None or one < each_matters * after for one in oracle.get("without", [])):
        return "one too small"
    return None
