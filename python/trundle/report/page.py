"""The page: one section an idea, the sentence first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import resources
from typing import Any

from trundle.report import cards, doubts, immaterial, remains, reproduce, sections
from trundle.report.given import Series
from trundle.report.markup import Html, tag
from trundle.report.section import contents
from trundle.report.verdict import headline, is_single

__all__ = ["render"]


def render(diagnosis: Mapping[str, Any], series: Mapping[str, Any]) -> str:
    """Render the whole report.

    Parameters
    ----------
    diagnosis
        The content of diagnosis.json (`trundle-diagnosis/1`).
    series
        The curves beside it: footprint, episodes with recorded and simulated motion, residual wrench,
        candidates, and how the answer was made (command, version, seed, noise, `input`: a list of what,
        sha256 and check, the command that prints it). `certificates` and `experiments`, if any, tell two
        `models` apart or state that nothing does, as the native half writes them. `unnamed` lists in words
        what the wrench without a name depends on, where the model "after" holds one. `doubts`:
        warnings, those of the diagnosis among them. Numbers may be None or NaN anywhere.

    Returns
    -------
    str
        One HTML page that needs nothing else: no network, no script. The same input gives the same bytes.
    """
    curves = Series.parse(series, single=is_single(diagnosis, series.get("unnamed")))
    warnings = [str(each) for each in series.get("doubts") or diagnosis.get("warnings") or ()]
    recording = str(diagnosis.get("recording") or "recording")
    parts: Sequence[tuple[str, str, Html | None]] = (
        ("missing", "", cards.missing(diagnosis, curves)),
        ("immaterial", "Immaterial", immaterial.immaterial(diagnosis)),
        ("motion", "Motion", sections.motion(diagnosis, curves)),
        ("wrench", "Wrench", sections.slow_pushes(curves)),
        ("residual", "Residual", remains.residual(diagnosis, curves)),
        ("ranking", "Candidates", sections.ranking(series)),
        ("doubts", "Alternatives", doubts.doubts(diagnosis, series, curves)),
        ("fit", "Figures", sections.figures_of_fit(diagnosis, curves)),
        ("nominal", "Parameters", sections.parameters(diagnosis)),
        ("reproduce", "Reproduce", reproduce.reproduce(series, str(diagnosis.get("wrench_pose") or ""))),
    )
    links = contents([(identity, name) for identity, name, part in parts if part is not None and name])
    body = [sections.answer(diagnosis, curves, warnings, recording, links), *(part for *_, part in parts)]
    head = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", name_="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", name_="color-scheme", content="light dark"),
        tag("title", f"{recording}: {headline(diagnosis)}"),
        tag("style", Html(_style())),
    )
    return "<!doctype html>\n" + tag("html", head, "\n", tag("body", tag("main", body)), lang="en") + "\n"


def _style() -> str:
    return resources.files("trundle.report").joinpath("style.css").read_text(encoding="utf-8")
