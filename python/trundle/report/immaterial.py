"""Effects that are detectable and too small to matter, in a table of their own with the reason."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from trundle.report import words
from trundle.report.given import finite
from trundle.report.markup import Html, tag
from trundle.report.quantity import ABSENT
from trundle.report.section import section
from trundle.report.tables import table

__all__ = ["immaterial"]


def immaterial(diagnosis: Mapping[str, Any]) -> Html | None:
    """Return the effects that are not corrected; None without any."""
    effects = [effect for effect in diagnosis.get("immaterial") or () if isinstance(effect, Mapping)]
    if not effects:
        return None
    text = (
        "The data show these effects, but left-out episodes are predicted almost as well without "
        "them. They are not in the model and have no part in the verdict."
    )
    rows = [
        [
            words.capitalised(words.effect(effect.get("effect"))),
            tag("span", words.spoken(effect.get("statement") or ""), class_="prose"),
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
    return ABSENT if share is None else words.percent(share)
