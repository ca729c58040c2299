"""Write the document of a comparison from its results."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from trundle.atomic import write_text
from trundle.experiments.comparison import figures, tables
from trundle.experiments.comparison.config import Settings
from trundle.experiments.comparison.curves import Curve, read_curves
from trundle.experiments.comparison.results import Results, read_costs, read_results
from trundle.experiments.comparison.scores import regret, success
from trundle.experiments.markdown import prose
from trundle.experiments.results import Row
from trundle.recording import TrundleError

__all__ = ["write_document"]

Learnt = Mapping[str, Sequence[Curve]]
"""Learning curves by training."""
Costs = Mapping[str, Mapping[str, float]]
"""Costs of decisions by `worlds/agent`."""


def write_document(out: Path, settings: Settings, config: Path) -> str:
    """Write `NAME.md` and its figures from `NAME/`; return the text.

    Parameters
    ----------
    out : Path
        Folder of the document, of `NAME/` and of `images/`.
    settings : Settings
        Its `name` is the document's.
    config : Path
        File of the comparison, for the command that reproduces the document.
    """
    folder = out / settings.name
    found = read_results(folder / "results.jsonl", settings)
    results = {name: group for name, group in found.items() if any(group.values())}
    if not results:
        raise TrundleError(f"{folder / 'results.jsonl'}: no results of these worlds: run without --redraw")
    learnt = read_curves(folder / "curves")
    draw_figures(out / "images", settings, results, learnt)
    text = render_page(settings, results, learnt, read_costs(folder / "costs.json"), config)
    write_text(out / f"{settings.name}.md", text)
    return text


def draw_figures(images: Path, settings: Settings, results: Results, learnt: Learnt) -> None:
    """Draw the figures."""
    images.mkdir(parents=True, exist_ok=True)
    figures.successes(images / f"{settings.name}_successes.png", settings, results)
    figures.profiles(images / f"{settings.name}_profiles.png", settings, results)
    if tables.learning(settings, results, learnt):
        figures.curves(images / f"{settings.name}_curves.png", settings, learnt)


def render_page(settings: Settings, results: Results, learnt: Learnt, costs: Costs, config: Path) -> str:
    """Return the text of the document; empty parts are omitted."""
    main = settings.agents[settings.main].title
    training = render_part("training", tables.learning(settings, results, learnt), name=settings.name)
    parts = {
        "targets": render_part("targets", tables.targets(settings, results)),
        "worth": render_part("pairs", tables.paired_differences(settings, results)),
        "diagnoses": render_part("diagnoses", tables.diagnoses(settings, results)),
        "policies": render_part(
            "policies", tables.policy_comparison(settings, results), main=main, training=training
        ),
    }
    groups = "\n\n".join(group_section(settings, name, group) for name, group in results.items())
    told = {"title": settings.title, "name": settings.name, "config": config.as_posix()}
    told |= {"headlines": headlines(settings, results), "groups": groups}
    text = render_part("main", tables.decision_costs(settings, costs), **told, **parts)
    return re.sub(r"\n{3,}", "\n\n", text) + "\n"


def render_part(group_section: str, table: str, /, **values: str) -> str:
    """Return the text around a table; empty without a table."""
    return prose("comparison", group_section, table=table, **values) if table else ""


def headlines(settings: Settings, results: Results) -> str:
    """Return a sentence for each group of worlds that compares the main agent with the others."""
    return "\n".join(headline(settings, name, group) for name, group in results.items())


def headline(settings: Settings, name: str, group: Mapping[str, list[Row]]) -> str:
    """Return the sentence of a group of worlds."""
    rates = {agent: success(rows) for agent, rows in group.items() if rows}
    mine = rates.pop(settings.main, None)
    title = f"- **{settings.worlds[name].title}** (`{name}`, {world_count(group)} worlds): "
    others = ", ".join(
        f"{settings.agents[agent].title} {100 * rate.value:.1f} %" for agent, rate in rates.items()
    )
    if mine is None:
        return f"{title}{others}."
    text = f"{title}{settings.agents[settings.main].title} succeeds in {tables.percent(mine)}"
    oracle = tables.oracle_rows(settings, group)
    if oracle:
        lost = tables.percent(regret(group[settings.main], oracle), ".0f")
        text += f" and loses {lost} of return to the oracle"
    return f"{text}; {others}." if others else f"{text}."


def group_section(settings: Settings, name: str, group: Mapping[str, list[Row]]) -> str:
    """Return the section of a group of worlds."""
    worlds = settings.worlds[name]
    seeds = sorted({row["seed"] for rows in group.values() for row in rows})
    options = ", ".join(f"`{key} = {value!r}`" for key, value in worlds.options.items())
    effects = "; ".join(effect_words(effect) for effect in worlds.effect)
    told = f"`{worlds.env}`{' with ' if options else ''}{options}, seeds {seeds[0]} to {seeds[-1]}."
    if effects:
        told += f" Further hidden effects: {effects}."
    parts = [
        f"### {worlds.title}: `{name}`",
        told,
        tables.outcomes(settings, group),
        tables.regret_table(settings, group),
    ]
    return "\n\n".join(parts)


def effect_words(effect: Mapping[str, object]) -> str:
    """Return an effect as in its table of the file."""
    values = ", ".join(f"{key} {value}" for key, value in effect.items() if key != "kind")
    return f"`{effect.get('kind')}` ({values})"


def world_count(group: Mapping[str, list[Row]]) -> int:
    """Return the number of worlds of a group."""
    return len({row["seed"] for rows in group.values() for row in rows})
