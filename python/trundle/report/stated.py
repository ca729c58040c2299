"""Which numbers a sentence already states, so that none is given twice."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from trundle.report.given import finite
from trundle.report.where import Place

__all__ = ["places_left", "unstated"]

_MEASURED = re.compile(r"([-\N{MINUS SIGN}]?\d+(?:\.(\d+))?) ± ")


def unstated(parameters: Mapping[str, Any], statement: object) -> dict[str, Any]:
    """Return the parameters whose values the statement does not give."""
    return {
        name: value
        for name, value in parameters.items()
        if not (isinstance(value, Mapping) and _states(statement, value.get("mean")))
    }


def places_left(place: Place, statement: object) -> list[str]:
    """Return the sentences about a place whose coordinates the statement does not give."""
    spots = [spot for spot in (place.body, place.world) if spot is not None]
    stated = {str(spot) for spot in spots if all(_states(statement, value) for value in spot.mean)}
    return [sentence for sentence in place.sentences() if not any(spot in sentence for spot in stated)]


def _states(statement: object, value: object) -> bool:
    mean = finite(value)
    if mean is None:
        return False
    found = _MEASURED.finditer(str(statement or ""))
    return any(
        abs(float(each[1].replace("\N{MINUS SIGN}", "-")) - mean)
        <= 0.5 * 10.0 ** -len(each[2] or "") * (1 + 1e-9)
        for each in found
    )
