"""The page: one section an idea, the sentence first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import resources
from typing import Any

from trundle.report import cards, sections
from trundle.report.given import Series
from trundle.report.markup import Html, tag
from trundle.report.verdict import headline

__all__ = ["render"]


def render(diagnosis: Mapping[str, Any], series: Mapping[str, Any]) -> str:
    """Render the whole report.

    Parameters
    ----------
    diagnosis
        The content of diagnosis.json (`trundle-diagnosis/1`).
    series
        The curves beside it: footprint, episodes with recorded and simulated motion, residual wrench,
        candidates, and how the answer was made (command, version, seed, noise). Numbers may be None or
        NaN anywhere.

    Returns
    -------
    str
        One HTML page that needs nothing else: no network, no script. The same input gives the same bytes.
    """
    curves = Series.parse(series)
    recording = str(diagnosis.get("recording") or "recording")
    parts: Sequence[Html | None] = (
        sections.answer(diagnosis, curves, recording),
        cards.missing(diagnosis),
        sections.motion(diagnosis, curves),
        sections.slow_pushes(curves),
        sections.figures_of_fit(diagnosis, curves),
        sections.residual(diagnosis, curves),
        sections.ranking(series),
        sections.nominal(diagnosis),
        sections.reproduce(series),
    )
    head = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", name_="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", name_="color-scheme", content="light dark"),
        tag("title", f"{recording}: {headline(diagnosis)}"),
        tag("style", Html(_style())),
    )
    return "<!doctype html>\n" + tag("html", head, "\n", tag("body", tag("main", parts)), lang="en") + "\n"


def _style() -> str:
    return resources.files("trundle.report").joinpath("style.css").read_text(encoding="utf-8")
