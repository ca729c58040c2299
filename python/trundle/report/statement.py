"""Numbers that the statement of an effect contains, so that its card does not repeat them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from trundle.report.location import Place
from trundle.report.series import finite

__all__ = ["location_sentences_not_in_statement", "parameters_not_in_statement"]

_ESTIMATE = re.compile(r"([-\N{MINUS SIGN}]?\d+(?:\.(\d+))?) ± ")


def parameters_not_in_statement(parameters: Mapping[str, Any], statement: object) -> dict[str, Any]:
    """Return the parameters whose values the statement does not contain."""
    return {
        name: value
        for name, value in parameters.items()
        if not (isinstance(value, Mapping) and _contains(statement, value.get("mean")))
    }


def location_sentences_not_in_statement(place: Place, statement: object) -> list[str]:
    """Return the sentences on a location whose coordinates the statement does not contain."""
    points = [point for point in (place.body, place.world) if point is not None]
    stated = {str(point) for point in points if all(_contains(statement, value) for value in point.mean)}
    return [sentence for sentence in place.sentences() if not any(point in sentence for point in stated)]


def _contains(statement: object, value: object) -> bool:
    """Return whether a statement contains an estimate that equals `value` to the digits it gives."""
    mean = finite(value)
    if mean is None:
        return False
    found = _ESTIMATE.finditer(str(statement or ""))
    return any(
        abs(float(each[1].replace("\N{MINUS SIGN}", "-")) - mean)
        <= 0.5 * 10.0 ** -len(each[2] or "") * (1 + 1e-9)
        for each in found
    )
