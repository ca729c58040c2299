"""Section "Detectable but immaterial": effects that the data show but that barely improve predictions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from trundle.report import wording
from trundle.report.markup import Html, tag
from trundle.report.quantity import ABSENT
from trundle.report.section import section
from trundle.report.series import finite
from trundle.report.tables import table

__all__ = ["immaterial"]


def immaterial(diagnosis: Mapping[str, Any]) -> Html | None:
    """Return the table of immaterial effects; None if there are none."""
    effects = [effect for effect in diagnosis.get("immaterial") or () if isinstance(effect, Mapping)]
    if not effects:
        return None
    text = (
        "The data show these effects. Left-out episodes are predicted almost as well without them, "
        "so they are not in the model and do not affect the verdict."
    )
    rows = [
        [
            wording.capitalise(wording.effect_name(effect.get("effect"))),
            tag("span", wording.typeset(effect.get("statement") or ""), class_="prose"),
            _share(effect.get("probability")),
        ]
        for effect in effects
    ]
    return section(
        "immaterial",
        "Detectable but immaterial",
        tag("p", text),
        table(("effect", "size", "probability"), rows),
    )


def _share(value: object) -> str:
    share = finite(value)
    return ABSENT if share is None else wording.format_percent(share)
