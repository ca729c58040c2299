"""Write the page of a blind benchmark from its results and the sealed truth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from string import Formatter

from trundle.atomic import write_text
from trundle.experiments.blind import error_tables, figures, follow_up_tables, tables
from trundle.experiments.blind.result_files import ResultFiles, Results
from trundle.experiments.blind.score import GROUPS, case_group
from trundle.experiments.results import Row
from trundle.recording import TrundleError

__all__ = ["write_page"]


@dataclass(frozen=True)
class Page:
    """The results behind one section of a page.

    Attributes
    ----------
    out : Path
        Folder of the page.
    name : str
        Of the page, and prefix of its figures.
    heads, rows, truths : sequence of dict
        As in `Results`, of all shares.
    file : Path
        Results of the first share.
    first : sequence of dict
        Rows of the first diagnoses, for a section about second ones.
    """

    out: Path
    name: str
    heads: Sequence[Row]
    rows: Sequence[Row]
    truths: Sequence[Row]
    file: Path
    first: Sequence[Row] = field(default=())

    @property
    def settings(self) -> Row:
        """Settings of the first share."""
        return dict(self.heads[0]["settings"])

    @property
    def cases(self) -> list[follow_up_tables.Case]:
        """Cases with all kinds of further pushes."""
        return follow_up_tables.cases_of(self.first, self.rows)

    def link(self, path: Path) -> str:
        """Return a path relative to the page."""
        return path.relative_to(self.out).as_posix()

    def figure(self, kind: str, paint: Callable[[Path, Sequence[Row]], None]) -> str:
        """Draw a figure and return its path relative to the page."""
        target = self.out / "images" / f"{self.name}_{kind}.png"
        target.parent.mkdir(parents=True, exist_ok=True)
        paint(target, self.rows)
        return self.link(target)


def write_page(out: Path, name: str, shares: Sequence[ResultFiles]) -> str:
    """Write `NAME.md` and its figures from the results of all shares that have some; return the text.

    Raises
    ------
    TrundleError
        If there are no results, or the sealed truth has changed.
    """
    limits = ResultFiles(shares[0].folder, f"{name}_limits")
    sections = []
    if present := [one for one in shares if one.answers().exists()]:
        first = make_page(out, name, present)
        template = "furniture" if "episodes" in first.settings else first.settings.get("generator", "wide")
        sections.append(render(template, first))
        for part, other in (("_without", "without"), ("_after", "after")):
            if present[0].answers(part).exists():
                sections.append(render(other, make_page(out, name, present, part, first.rows)))
    if limits.answers().exists():
        sections.append(render("limits", make_page(out, name, [limits])))
    if not sections:
        raise TrundleError(f"{shares[0].answers()}: no results to draw: run without --redraw")
    text = "\n\n".join(sections) + "\n"
    if not present:
        text = f"# The blind benchmark\n\n{text}"
    write_text(out / f"{name}.md", text)
    return text


def make_page(
    out: Path, name: str, shares: Sequence[ResultFiles], part: str = "", first: Sequence[Row] = ()
) -> Page:
    """Read results of all shares."""
    found: list[Results] = [one.read(part) for one in shares]
    rows = [row for one in found for row in one.rows]
    truths = [truth for one in found for truth in one.truths]
    return Page(out, name, [one.head for one in found], rows, truths, shares[0].answers(part), first)


def render(template: str, page: Page) -> str:
    """Return a text of `prose/` with the parts that it names in braces."""
    text = files("trundle.experiments.blind").joinpath("prose", f"{template}.md").read_text(encoding="utf-8")
    names = {name for _, name, _, _ in Formatter().parse(text) if name}
    return text.format(**{name: PARTS[name](page) for name in names}).strip()


def counts(page: Page) -> str:
    """Return the numbers of recordings by group."""
    groups = [case_group(row["truth"]) for row in page.rows]
    shown = ", ".join(f"{groups.count(name)} {name}" for name in GROUPS)
    return f"{len(page.rows)} recordings ({shown})"


def shares_done(page: Page) -> str:
    """Return how many shares have results, if the range has shares."""
    shares = page.settings.get("shares", 1)
    return f", {len(page.heads)} of {shares} shares" if shares > 1 else ""


def diagnosing_versions(page: Page) -> str:
    """Return the versions of the diagnosing sources."""
    return ", ".join(
        f"`{one}`" for one in sorted({head["code"]["diagnosis"].split("-")[0] for head in page.heads})
    )


def dropped(page: Page) -> str:
    """Return the number of cases without a material draw."""
    return str(sum(truth["digest"] is None for truth in page.truths))


def redrawn(page: Page) -> str:
    """Return the number of rejected draws of the diagnosed cases."""
    return str(sum(len(row["truth"]["attempts"]) - 1 for row in page.rows if row["truth"]["names"]))


def pushes(page: Page) -> str:
    """Return a description of the pushes of furniture."""
    same = "all with one initial pose and one grasp, without rotation"
    ways = same if page.settings.get("alike") else "3 or 4 grasps"
    return f"{page.settings['episodes']} episodes of 6 s, {ways}"


def size_text(page: Page) -> str:
    """Return a sentence about the size of hidden effects, if it is not the drawn one."""
    size = page.settings.get("size", 1.0)
    text = f" The hidden effect then has {size:g} of that size. The targets below do not apply to it."
    return text if size != 1.0 else ""


ROBOTS = {
    "own": "eight arms and benches with one to six joints",
    "wheels": "nine robots of robosuite, dm_control and gymnasium-robotics with two to seven joints",
}


def robots(page: Page) -> str:
    """Return a description of the robots of mechanisms."""
    return " and ".join(ROBOTS[name] for name in page.settings.get("robots", ["own"]))


def of_rows(make: Callable[[Sequence[Row]], str]) -> Callable[[Page], str]:
    """Return a part that depends on the diagnosed rows only."""
    return lambda page: make(page.rows)


ROW_TABLES = (
    *(
        tables.instruments,
        tables.single_effects,
        tables.wrong_answers,
        tables.costs,
        tables.explained_misfits,
    ),
    *(error_tables.places, error_tables.parameters, error_tables.intervals, error_tables.probabilities),
)
PARTS: dict[str, Callable[[Page], str]] = {
    **{make.__name__: of_rows(make) for make in ROW_TABLES},
    "range": lambda page: str(page.settings["range"]),
    "first_seed": lambda page: str(page.settings["first"]),
    "shares": shares_done,
    "counts": counts,
    "dropped": dropped,
    "redrawn": redrawn,
    "versions": diagnosing_versions,
    "sha256": lambda page: ", ".join(f"`{head['sha256']}`" for head in page.heads),
    "pushes": pushes,
    "robots": robots,
    "held_out": lambda page: f"{min(2, page.settings['episodes'] - 1)} held out",
    "size": size_text,
    "results": lambda page: page.link(page.file),
    "answers": lambda page: page.link(page.file.with_name(f"{page.file.stem}.answers.json")),
    "targets_furniture": lambda page: tables.accuracy("furniture", page.rows),
    "targets_wide": lambda page: tables.accuracy("wide", page.rows),
    "targets_mechanism": lambda page: tables.accuracy("mechanism", page.rows),
    "conditions": lambda page: tables.instruments(page.rows, tables.MECHANISM_CLASSES),
    "rejected_mechanisms": lambda page: tables.rejections(page.truths, ("robot", "source", "rate_class")),
    "ties": of_rows(tables.tie_text),
    "rejections": lambda page: tables.rejections(page.truths),
    "without": of_rows(tables.leave_one_out),
    "limits": lambda page: tables.detection_limits(page.settings, page.rows),
    "scores": of_rows(error_tables.score_text),
    "platt": of_rows(error_tables.platt_text),
    "figure_confusion": lambda page: page.figure("confusion", figures.confusion),
    "figure_calibration": lambda page: page.figure("calibration", figures.reliability_diagram),
    "figure_gain": lambda page: page.figure("gain", figures.gains),
    "figure_limits": lambda page: page.figure("limits", figures.detection_limits),
    "second_control": lambda page: follow_up_tables.ANY_CONTROL if page.settings["alike"] else "",
    "requests": lambda page: follow_up_tables.case_counts(page.first, page.cases),
    "rates": lambda page: follow_up_tables.rates(page.cases),
    "rates_tied": lambda page: follow_up_tables.rates(follow_up_tables.initially_tied(page.cases)),
    "pairs": lambda page: follow_up_tables.pairs(page.cases),
    "efforts": lambda page: follow_up_tables.efforts(page.cases),
    "cases_by_effect": lambda page: follow_up_tables.by_effect(page.cases),
    "all_cases": lambda page: follow_up_tables.all_cases(page.cases),
}
"""Parts that a text of `prose/` may name in braces."""
