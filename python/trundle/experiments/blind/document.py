"""Write the document of a blind benchmark from its results and the sealed truth."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from trundle.atomic import write_text
from trundle.experiments.blind import figures, follow_up_tables, tables
from trundle.experiments.blind.sealed import open_sealed
from trundle.experiments.markdown import prose
from trundle.experiments.results import Row, read_trials

__all__ = ["read_rows", "write_document"]


def write_document(out: Path, name: str) -> str:
    """Write `NAME.md` and its figures from `proof/NAME*.jsonl`; return the text.

    Parameters
    ----------
    out : Path
        Folder of the document, of `proof/` and of `images/`.
    name : str
    """
    kept = out / "proof"
    parts = [
        (kept / f"{name}.jsonl", main_section),
        (kept / f"{name}_without.jsonl", leave_one_out_section),
        (kept / f"{name}_after.jsonl", follow_up_section),
        (kept / f"{name}_limits.jsonl", limits_section),
    ]
    sections = [make(path, out, name) for path, make in parts if path.exists()]
    text = "\n\n".join(["# The blind benchmark", *sections]) + "\n"
    write_text(out / f"{name}.md", text)
    return text


def read_rows(path: Path) -> tuple[Row, list[Row]]:
    """Return the settings of a file of results, and each diagnosis with the sealed truth.

    The SHA-256 in the results must match the file of the sealed truth.
    """
    settings, found = read_trials(path)
    stem = path.stem.removesuffix("_without").removesuffix("_after")
    truths = open_sealed(path.with_name(f"{stem}.answers.json"), settings["sha256"])
    names = ("case", "without", "push")
    rows = [
        {
            **{name: one[name] for name in names if name in one},
            "answer": one,
            "truth": truths[one["case"]],
            "seconds": one["seconds"],
        }
        for one in found
    ]
    done = {row["case"] for row in rows}
    settings["undone"] = sum("oracle" in truth and case not in done for case, truth in truths.items())
    settings["given_up"] = [truth["names"] for truth in truths.values() if "oracle" not in truth]
    return settings, sorted(rows, key=lambda row: str(row["case"]))


def main_section(path: Path, out: Path, name: str) -> str:
    """Return the section of the main benchmark."""
    settings, rows = read_rows(path)
    pictures = {
        "confusion": lambda target: figures.confusion(target, rows),
        "calibration": lambda target: figures.reliability_diagram(target, rows),
        "gain": lambda target: figures.gains(target, rows),
    }
    values = {
        **tables.setup_text(settings),
        "about": tables.case_counts(settings, rows),
        "targets": tables.targets(rows),
        "by_effect": tables.by_effect(settings, rows),
        "foreign": tables.by_out_of_catalogue(rows),
        "places": tables.places(rows),
        "parameters": tables.parameters(rows),
        "calibration": tables.calibration_table(rows),
        "wrong": tables.wrong_answers(rows),
        "sha256": settings["sha256"],
        "results": f"proof/{path.name}",
        "answers": f"proof/{path.stem}.answers.json",
        **{key: draw_figure(out, f"{name}_{key}.png", paint) for key, paint in pictures.items()},
    }
    values = {("picture_" + key if key in pictures else key): value for key, value in values.items()}
    values["calibration"] = tables.calibration_table(rows)
    return prose("blind", "main", **values)


def leave_one_out_section(path: Path, out: Path, name: str) -> str:
    """Return the section of the diagnoses without the true effect."""
    _, rows = read_rows(path)
    return prose("blind", "without", table=tables.leave_one_out(rows), results=f"proof/{path.name}")


def follow_up_section(path: Path, out: Path, name: str) -> str:
    """Return the section of the requested pushes."""
    settings, rows = read_rows(path)
    first = read_rows(path.with_name(f"{name}.jsonl"))[1]
    cases = follow_up_tables.cases_of(first, rows)
    values = {
        "any": follow_up_tables.ANY_CONTROL if settings["alike"] else "",
        "about": follow_up_tables.case_counts(first, cases),
        "rates": follow_up_tables.rates(cases),
        "tied": follow_up_tables.rates(follow_up_tables.initially_tied(cases)),
        "pairs": follow_up_tables.pairs(cases),
        "efforts": follow_up_tables.efforts(cases),
        "by_effect": follow_up_tables.by_effect(cases),
        "cases": follow_up_tables.all_cases(cases),
        "results": f"proof/{path.name}",
    }
    return prose("blind", "after", **values)


def limits_section(path: Path, out: Path, name: str) -> str:
    """Return the section of the detection limits."""
    settings, rows = read_rows(path)
    picture = draw_figure(out, f"{name}_limits.png", lambda target: figures.detection_limits(target, rows))
    return prose(
        "blind",
        "limits",
        table=tables.detection_limits(settings, rows),
        picture=picture,
        results=f"proof/{path.name}",
    )


def draw_figure(out: Path, file: str, paint: Any) -> str:
    """Draw a figure and return its path relative to the document."""
    target = out / "images" / file
    target.parent.mkdir(parents=True, exist_ok=True)
    paint(target)
    return f"images/{file}"
