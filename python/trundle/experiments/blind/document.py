"""The document of a proof, written from the results and the sealed answers that are kept."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from trundle.atomic import write_text
from trundle.experiments.blind import figures, tables, tables_after
from trundle.experiments.blind.sealed import open_sealed
from trundle.experiments.markdown import prose
from trundle.experiments.results import Row, read_trials

__all__ = ["rows_of", "write_document"]


def write_document(out: Path, name: str) -> str:
    """Write `NAME.md` and its figures from `proof/NAME*.jsonl`; return what is on it.

    Parameters
    ----------
    out : Path
        Folder of the document, of `proof/` and of `images/`.
    name : str
    """
    kept = out / "proof"
    parts = [
        (kept / f"{name}.jsonl", main),
        (kept / f"{name}_without.jsonl", without),
        (kept / f"{name}_after.jsonl", after),
        (kept / f"{name}_limits.jsonl", limits),
    ]
    sections = [make(path, out, name) for path, make in parts if path.exists()]
    text = "\n\n".join(["# The concealed proof", *sections]) + "\n"
    write_text(out / f"{name}.md", text)
    return text


def rows_of(path: Path) -> tuple[Row, list[Row]]:
    """Return the settings of results, and each diagnosis with the sealed answer beside it.

    The answers must be those whose SHA-256 stands with the results.
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


def main(path: Path, out: Path, name: str) -> str:
    """Return the section of the main proof."""
    settings, rows = rows_of(path)
    pictures = {
        "confusion": lambda target: figures.confusion(target, rows),
        "calibration": lambda target: figures.reliability(target, rows),
        "gain": lambda target: figures.gains(target, rows),
    }
    values = {
        **tables.described(settings),
        "about": tables.about(settings, rows),
        "targets": tables.targets(rows),
        "by_effect": tables.by_effect(settings, rows),
        "foreign": tables.by_foreign(rows),
        "places": tables.places(rows),
        "parameters": tables.parameters(rows),
        "calibration": tables.calibrated(rows),
        "wrong": tables.wrong_answers(rows),
        "sha256": settings["sha256"],
        "results": f"proof/{path.name}",
        "answers": f"proof/{path.stem}.answers.json",
        **{key: draw(out, f"{name}_{key}.png", paint) for key, paint in pictures.items()},
    }
    values = {("picture_" + key if key in pictures else key): value for key, value in values.items()}
    values["calibration"] = tables.calibrated(rows)
    return prose("blind", "main", **values)


def without(path: Path, out: Path, name: str) -> str:
    """Return the section of leave-one-out."""
    _, rows = rows_of(path)
    return prose("blind", "without", table=tables.left_out(rows), results=f"proof/{path.name}")


def after(path: Path, out: Path, name: str) -> str:
    """Return the section of the pushes that were asked for."""
    settings, rows = rows_of(path)
    first = rows_of(path.with_name(f"{name}.jsonl"))[1]
    cases = tables_after.cases_of(first, rows)
    values = {
        "any": tables_after.ANY_CONTROL if settings["alike"] else "",
        "about": tables_after.about(first, cases),
        "rates": tables_after.rates(cases),
        "tied": tables_after.rates(tables_after.tied_first(cases)),
        "pairs": tables_after.pairs(cases),
        "efforts": tables_after.efforts(cases),
        "by_effect": tables_after.by_effect(cases),
        "cases": tables_after.each(cases),
        "results": f"proof/{path.name}",
    }
    return prose("blind", "after", **values)


def limits(path: Path, out: Path, name: str) -> str:
    """Return the section of detection limits."""
    settings, rows = rows_of(path)
    picture = draw(out, f"{name}_limits.png", lambda target: figures.limits(target, rows))
    return prose(
        "blind", "limits", table=tables.limits(settings, rows), picture=picture, results=f"proof/{path.name}"
    )


def draw(out: Path, file: str, paint: Any) -> str:
    """Draw a figure and return its path in the document."""
    target = out / "images" / file
    target.parent.mkdir(parents=True, exist_ok=True)
    paint(target)
    return f"images/{file}"
