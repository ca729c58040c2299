"""The whole page: header with the verdict, then the sections."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from trundle.report import alternatives, cards, residual, sections, tables, unexplained
from trundle.report.jinja import render_template
from trundle.report.reproduce import reproduce
from trundle.report.series import Series
from trundle.report.use import use
from trundle.report.verdict import headline, is_single

__all__ = ["render"]

_CONTENTS = (
    ("missing", "Missing effects"),
    ("symptoms", "What is known"),
    ("immaterial", "Immaterial"),
    ("motion", "Motion"),
    ("wrench", "Wrench"),
    ("residual", "Residual"),
    ("ranking", "Candidates"),
    ("alternatives", "Alternatives"),
    ("fit", "Errors"),
    ("nominal", "Parameters"),
    ("reproduce", "Reproduce"),
)
"""Sections that the table of contents lists: anchor and key of the data, and text."""


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
        - `black_box`: whether a caller's `step` function simulates the motion;
        - `doubts`: warnings, including those of the diagnosis.

    Returns
    -------
    str
        One HTML page, which needs no network and works without scripts. The same input gives the same bytes.
    """
    curves = Series.parse(series, single=is_single(diagnosis, series.get("unnamed")))
    recording = str(diagnosis.get("recording") or "recording")
    symptoms = unexplained.symptoms(diagnosis, curves, series.get("candidates") or ())
    data = {
        "symptoms": symptoms,
        "predictors": unexplained.predictor_rows(curves) if symptoms else [],
        "missing": [] if symptoms else cards.missing_effects(diagnosis),
        "immaterial": tables.immaterial_effects(diagnosis),
        "motion": sections.motion(diagnosis, curves),
        "wrench": sections.wrench(curves),
        "residual": residual.residual_section(diagnosis, curves),
        "ranking": tables.candidates(diagnosis, series.get("candidates") or ()),
        "alternatives": alternatives.alternatives(diagnosis, series, curves),
        "fit": sections.error_metrics(diagnosis, curves),
        "nominal": sections.parameters(diagnosis, curves),
        "reproduce": reproduce(series),
    }
    warnings = series.get("doubts") or diagnosis.get("warnings") or ()
    return render_template(
        "trundle.report",
        "report.html",
        title=f"{recording}: {headline(diagnosis)}",
        recording=recording,
        headline=headline(diagnosis),
        verdict=diagnosis.get("verdict"),
        wrench_pose=diagnosis.get("wrench_pose"),
        header=sections.answer_header(diagnosis, curves, warnings),
        use=use(diagnosis, curves),
        entries=[(identity, name) for identity, name in _CONTENTS if data[identity]],
        **data,
    )
