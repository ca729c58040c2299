"""The whole page: header with the verdict, then the sections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import resources
from typing import Any

from trundle.report import alternatives, cards, immaterial, reproduce, residual, sections
from trundle.report.markup import Html, tag
from trundle.report.section import contents
from trundle.report.series import Series
from trundle.report.verdict import headline, is_single

__all__ = ["render"]


def render(diagnosis: Mapping[str, Any], series: Mapping[str, Any]) -> str:
    """Render the whole report.

    Parameters
    ----------
    diagnosis
        The content of diagnosis.json (`trundle-diagnosis/1`).
    series
        The curves and the provenance of the diagnosis. Any number may be None or NaN. The keys are

        - footprint, support, episodes (recorded and simulated motion, residual wrench), candidates;
        - command, version, seed, noise, and `input`: a list of what, sha256 and check (the command
          that prints the sum);
        - `certificates` and `experiments`: the native module's comparisons of two `models`;
        - `unnamed`: descriptions of the discrepancy's inputs, if the model "after" contains one;
        - `doubts`: warnings, including those of the diagnosis.

    Returns
    -------
    str
        One HTML page without scripts or external resources. The same input gives the same bytes.
    """
    curves = Series.parse(series, single=is_single(diagnosis, series.get("unnamed")))
    warnings = [str(each) for each in series.get("doubts") or diagnosis.get("warnings") or ()]
    recording = str(diagnosis.get("recording") or "recording")
    parts: Sequence[tuple[str, str, Html | None]] = (
        ("missing", "", cards.missing_effects(diagnosis, curves)),
        ("immaterial", "Immaterial", immaterial.immaterial(diagnosis)),
        ("motion", "Motion", sections.motion(diagnosis, curves)),
        ("wrench", "Wrench", sections.wrench(curves)),
        ("residual", "Residual", residual.residual_section(diagnosis, curves)),
        ("ranking", "Candidates", sections.ranking(series)),
        ("alternatives", "Alternatives", alternatives.alternatives(diagnosis, series, curves)),
        ("fit", "Errors", sections.error_metrics(diagnosis, curves)),
        ("nominal", "Parameters", sections.parameters(diagnosis)),
        ("reproduce", "Reproduce", reproduce.reproduce(series, str(diagnosis.get("wrench_pose") or ""))),
    )
    links = contents([(identity, name) for identity, name, part in parts if part is not None and name])
    body = [
        sections.answer_header(diagnosis, curves, warnings, recording, links),
        *(part for *_, part in parts),
    ]
    head = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", name_="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", name_="color-scheme", content="light dark"),
        tag("title", f"{recording}: {headline(diagnosis)}"),
        tag("style", Html(_style_sheet())),
    )
    return "<!doctype html>\n" + tag("html", head, "\n", tag("body", tag("main", body)), lang="en") + "\n"


def _style_sheet() -> str:
    return resources.files("trundle.report").joinpath("style.css").read_text(encoding="utf-8")
