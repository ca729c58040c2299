"""Write the document of a comparison from its results."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from trundle.atomic import write_text
from trundle.experiments import figure_style
from trundle.experiments.comparison import figures, page, tables
from trundle.experiments.comparison.config import Settings
from trundle.experiments.comparison.results import Curves, Results, read_costs, read_curves, read_results
from trundle.experiments.comparison.scores import (
    is_untouched_success,
    regret,
    scores,
    time_to_success,
    untouched_success,
)
from trundle.experiments.markdown import prose
from trundle.experiments.results import Row
from trundle.experiments.statistics import difference
from trundle.recording import TrundleError

__all__ = ["headlines", "write_document"]

Group = Mapping[str, Sequence[Row]]
"""Rows by agent."""


def write_document(out: Path, settings: Settings, config: Path) -> str:
    """Write `NAME.md` with its figures, and the page `NAME.html`, from `NAME/`; return the text.

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
    results = read_results(folder / "results.jsonl", settings)
    if not results:
        raise TrundleError(f"{folder / 'results.jsonl'}: no results of these worlds: run without --redraw")
    curves = read_curves(Path(settings.training or folder) / "curves")
    drawn = {
        "successes": figures.successes(settings, results),
        "profiles": figures.profiles(settings, results),
    }
    if tables.learning(settings, results, curves):
        drawn["curves"] = figures.curves(settings, curves)
    for name, figure in drawn.items():
        figure_style.save(figure, out / "images" / f"{settings.name}_{name}.png")
    costs = tables.decision_costs(settings, read_costs(folder / "costs.json"))
    text = render_page(settings, results, curves, costs, config)
    write_text(out / f"{settings.name}.md", text)
    write_text(out / f"{settings.name}.html", page.render(text, settings, results, curves))
    return text


def render_page(settings: Settings, results: Results, curves: Curves, costs: str, config: Path) -> str:
    """Return the text of the document; empty parts are omitted."""
    training = render_part("training", tables.learning(settings, results, curves), name=settings.name)
    policies = tables.policy_comparison(settings, results)
    text = prose(
        "comparison",
        "main",
        title=settings.title,
        name=settings.name,
        config=config.as_posix(),
        headlines=headlines(settings, results),
        groups="\n\n".join(group_section(settings, name, group) for name, group in results.items()),
        table=costs,
        targets=render_part("targets", tables.targets(settings, results)),
        pairs=render_part("pairs", tables.paired_differences(settings, results)),
        diagnoses=render_part("diagnoses", tables.diagnoses(settings, results)),
        policies=render_part(
            "policies", policies, main=settings.agents[settings.main].title, training=training
        ),
    )
    return re.sub(r"\n{3,}", "\n\n", text) + "\n"


def render_part(part: str, table: str, /, **values: str) -> str:
    """Return the text around a table; empty without a table."""
    return prose("comparison", part, table=table, **values) if table else ""


def headlines(settings: Settings, results: Results) -> str:
    """Return where trained policies are ahead, and a sentence for each group of worlds."""
    groups = [headline(settings, name, group) for name, group in results.items()]
    return "\n".join([*policies_ahead(settings, results), *groups])


def policies_ahead(settings: Settings, results: Results) -> list[str]:
    """Return the groups in which a policy surely succeeds more often, costs less or is faster."""
    compared, ahead = False, []
    for name, group in results.items():
        for agent, rows in group.items():
            if not settings.agents[agent].is_trained or settings.main not in group:
                continue
            compared, mine = True, group[settings.main]
            gain = difference(*(scores(one, is_untouched_success) for one in (rows, mine)))
            excess = {"cost": regret(rows, mine), "time": regret(rows, mine, time_to_success)}
            if gain.low > 0.0 or any(one.high < 0.0 for one in excess.values()):
                figures = [f"{key} {tables.percent(one, '+.0f')}" for key, one in excess.items()]
                words = ", ".join([f"success {gain.text('+.1f', 100.0)} points", *figures])
                ahead.append(f"{settings.agents[agent].title} in `{name}` ({words})")
    if not compared:
        return []
    title = settings.agents[settings.main].title
    return [f"- **Trained policies that are ahead of {title}**: {'; '.join(ahead) or 'none in any group'}."]


def headline(settings: Settings, name: str, group: Group) -> str:
    """Return the sentence of a group of worlds."""
    titles = {agent: settings.agents[agent].title for agent in group}
    rates = {agent: untouched_success(rows) for agent, rows in group.items()}
    main = rates.pop(settings.main, None)
    parts = []
    if main is not None:
        parts.append(f"{titles[settings.main]} succeeds without touching in {tables.percent(main)}")
        if oracle := tables.oracle_rows(settings, group):
            lost = tables.percent(regret(group[settings.main], oracle), ".0f")
            parts[0] += f" and loses {lost} of return to the oracle"
    if rates:
        parts.append(", ".join(f"{titles[agent]} {100 * rate.value:.1f} %" for agent, rate in rates.items()))
    return f"- **{settings.worlds[name].title}** (`{name}`, {len(seeds(group))} worlds): {'; '.join(parts)}."


def seeds(group: Group) -> list[int]:
    """Return the seeds of a group of worlds, in order."""
    return sorted({row["seed"] for rows in group.values() for row in rows})


def group_section(settings: Settings, name: str, group: Group) -> str:
    """Return the section of a group of worlds."""
    worlds, every = settings.worlds[name], seeds(group)
    options = ", ".join(f"`{key} = {value!r}`" for key, value in worlds.options.items())
    effects = "; ".join(effect_words(effect) for effect in worlds.effect)
    about = f"`{worlds.env}`{' with ' if options else ''}{options}, seeds {every[0]} to {every[-1]}."
    more = f" Further hidden effects: {effects}." if effects else ""
    parts = [tables.outcomes(settings, group), tables.regret_table(settings, group)]
    return "\n\n".join([f"### {worlds.title}: `{name}`", about + more, *parts])


def effect_words(effect: Mapping[str, object]) -> str:
    """Return an effect as in its table of the file."""
    values = ", ".join(f"{key} {value}" for key, value in effect.items() if key != "kind")
    return f"`{effect.get('kind')}` ({values})"
