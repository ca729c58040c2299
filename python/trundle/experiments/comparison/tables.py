"""Tables of a comparison's document."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from operator import itemgetter
from statistics import mean

import trundle
from trundle.envs.ids import task_of
from trundle.experiments.comparison.config import Settings, Target, Worlds
from trundle.experiments.comparison.results import Curves, Results
from trundle.experiments.comparison.scores import (
    MAX_QUICK_PUSHES,
    is_untouched_success,
    middle,
    quick_success,
    regret,
    regret_iqm,
    scores,
    share,
    success,
    time_to_success,
    untouched_success,
)
from trundle.experiments.markdown import table
from trundle.experiments.results import Row
from trundle.experiments.statistics import Estimate, difference, improvement

__all__ = [
    "decision_costs",
    "diagnoses",
    "learning",
    "oracle_rows",
    "outcomes",
    "paired_differences",
    "percent",
    "policy_comparison",
    "regret_table",
    "targets",
]

Rows = Sequence[Row]
NONE = "–"
OWN_WHEEL = "viscous_wheel"
"""Law of the agent's initial model; diagnoses do not name it."""
SECOND_WHEEL = "second_wheel"
"""Name of a second wheel in diagnoses."""
DIFFERENCES = [
    "success without touching, percentage points",
    "cost, sums",
    "probability of better return",
    "time, sums",
]


def percent(found: Estimate, form: str = ".1f") -> str:
    """Return a share and its interval in percent."""
    return found.text(form, 100.0, " %")


def table_or_nothing(head: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    """Return a table; empty without lines."""
    return table(head, lines) if lines else ""


def outcomes(settings: Settings, group: Mapping[str, Rows]) -> str:
    """Return the outcomes of the episodes of a group of worlds."""
    lines = []
    for name, rows in group.items():
        agent = settings.agents[name]
        quick = percent(quick_success(rows, settings.push)) if agent.learns else NONE
        lost, hit = share(rows, itemgetter("lost")), share(rows, lambda row: row["touches"] > 0)
        contact = f"{mean(row['contact'] for row in rows):.2f}" if "contact" in rows[0] else NONE
        distance = middle(rows, lambda row: row["distance"] / row["radius"]).text(".3f")
        heading = middle(rows, itemgetter("heading")).text(".1f", 57.29578)
        rates = [percent(one) for one in (untouched_success(rows), success(rows))]
        lines.append([agent.title, *rates, quick, percent(lost), percent(hit), contact, distance, heading])
    head = [
        "agent",
        "success without touching",
        "success",
        f"after ≤ {MAX_QUICK_PUSHES} learning pushes",
        "lost",
    ]
    return table(
        [*head, "collision", "mean contact, s", "remaining distance / radius", "remaining heading error, °"],
        lines,
    )


def regret_table(settings: Settings, group: Mapping[str, Rows]) -> str:
    """Return the time and the regret relative to the oracle in a group of worlds."""
    oracle, lines = oracle_rows(settings, group), []
    for name, rows in group.items():
        agent, time = settings.agents[name], middle(rows, time_to_success)
        fits = middle(rows, itemgetter("fits")).text(".1f") if agent.learns else NONE
        excess = [NONE] * 3
        if oracle:
            three = (regret_iqm(rows, oracle), regret(rows, oracle), regret(rows, oracle, time_to_success))
            excess = [percent(one, ".0f") for one in three]
        lines.append([agent.title, time.text(".1f"), f"{time.value / settings.push:.0f}", fits, *excess])
    head = ["agent", "time to success, s", f"pushes of {settings.push:g} s", "fits"]
    return table([*head, "regret, IQM", "regret, sums", "regret of time"], lines)


def oracle_rows(settings: Settings, group: Mapping[str, Rows]) -> Rows:
    """Return the rows of the first oracle; empty without one."""
    return next((rows for name, rows in group.items() if settings.agents[name].kind == "oracle"), [])


def targets(settings: Settings, results: Results) -> str:
    """Return targets and results."""
    lines = []
    for target in settings.targets:
        group = results.get(target.worlds, {})
        found = target_figure(settings, target, group.get(target.agent, []), oracle_rows(settings, group))
        if found:
            who = [f"`{target.worlds}`", settings.agents[target.agent].title]
            lines.append([*who, target.figure, *target_cells(target, found)])
    return table_or_nothing(["worlds", "agent", "figure", "target", "result", ""], lines)


def target_figure(settings: Settings, target: Target, rows: Rows, oracle: Rows) -> Estimate | None:
    """Return the figure of a target; None without the episodes that it needs."""
    if not rows or (target.figure == "regret" and not oracle):
        return None
    if target.figure == "regret":
        return regret(rows, oracle)
    figures = {"success": success, "success without touching": untouched_success}
    return figures[target.figure](rows) if target.figure in figures else quick_success(rows, settings.push)


def target_cells(target: Target, found: Estimate) -> list[str]:
    """Return a target, the result, and whether the result meets the target."""
    least = -math.inf if target.least is None else target.least
    most = math.inf if target.most is None else target.most
    bound = f"≤ {100 * most:g} %" if target.least is None else f"≥ {100 * least:g} %"
    meets, surely = least <= found.value <= most, least <= found.low and found.high <= most
    verdict = "met" if surely else "met, interval reaches beyond" if meets else "**not met**"
    return [bound, percent(found), verdict]


def paired_differences(settings: Settings, results: Results) -> str:
    """Return the differences between the agents of each pair."""
    lines = []
    for pair in settings.pairs:
        for name, group in results.items():
            if group.keys() >= set(pair):
                titles = " over ".join(settings.agents[agent].title for agent in pair)
                lines.append([titles, f"`{name}`", *difference_cells(*(group[agent] for agent in pair))])
    return table_or_nothing(["pair", "worlds", *DIFFERENCES], lines)


def policy_comparison(settings: Settings, results: Results) -> str:
    """Return the differences between trained policies and the main agent."""
    lines = [
        [f"`{name}`", settings.agents[agent].title, *difference_cells(rows, group[settings.main])]
        for name, group in results.items()
        for agent, rows in group.items()
        if settings.main in group and settings.agents[agent].is_trained
    ]
    return table_or_nothing(["worlds", "policy", *DIFFERENCES], lines)


def difference_cells(a: Rows, b: Rows) -> list[str]:
    """Return the differences between two agents."""
    return [
        difference(*(scores(rows, is_untouched_success) for rows in (a, b))).text("+.1f", 100.0),
        percent(regret(a, b), "+.0f"),
        percent(improvement(*(scores(rows, itemgetter("return")) for rows in (a, b))), ".0f"),
        percent(regret(a, b, time_to_success), "+.0f"),
    ]


def diagnoses(settings: Settings, results: Results) -> str:
    """Return the effects that diagnosing agents named."""
    lines = [
        [
            f"`{name}`",
            settings.agents[agent].title,
            *naming_cells(rows, hidden_effects(settings.worlds[name])),
        ]
        for name, group in results.items()
        for agent, rows in group.items()
        if settings.agents[agent].settings.get("diagnose")
    ]
    return table_or_nothing(["worlds", "agent", "correct name", "wrong name"], lines)


def hidden_effects(worlds: Worlds) -> set[str] | None:
    """Return the hidden effects besides a wheel, by the names of diagnoses; None if worlds differ in them."""
    task = task_of(worlds.env)
    drawn = worlds.options.get("hidden", task and task.FIXED.get("hidden"))
    if drawn not in ("none", "locked"):
        return None
    names = {law["kind"]: law["effect"] for law in trundle.effects()}
    laws = [*worlds.options.get("effects", []), *worlds.effect]
    found = [names[law["kind"]] for law in laws if law.get("kind") in names]
    wheels = found.count(OWN_WHEEL) + (drawn == "locked")
    return {*found, *([SECOND_WHEEL] if wheels > 1 else [])} - {OWN_WHEEL}


def naming_cells(rows: Rows, hidden: set[str] | None) -> list[str]:
    """Return the rates of correct and of wrong names."""
    if hidden is None:
        return [NONE, NONE]
    right = share(rows, lambda row: bool(hidden & set(row["named"])))
    wrong = share(rows, lambda row: bool(set(row["named"]) - hidden))
    return [percent(right) if hidden else NONE, percent(wrong)]


def learning(settings: Settings, results: Results, curves: Curves) -> str:
    """Return the training cost and the final result of each policy."""
    playing = {agent for group in results.values() for agent in group}
    lines = []
    for name, agent in settings.agents.items():
        if name in playing and agent.curve in curves:
            lines.append([agent.title, *training_cells(curves[agent.curve])])
    head = ["policy", "runs", "parameters", "steps of each", "simulated", "CPU time", "success at the end, %"]
    return table_or_nothing([*head, "flattened"], lines)


def training_cells(runs: Rows) -> list[str]:
    """Return the number and cost of a policy's training runs, and their results."""
    hours = sum(run["simulated_seconds"] for run in runs) / len(runs) / 3600
    minutes = sum(run["cpu_seconds"] for run in runs) / len(runs) / 60
    return [
        str(len(runs)),
        f"{runs[0]['parameters']:,}",
        f"{runs[0]['curve'][-1]['step']:,.0f}",
        f"{hours:.1f} h",
        NONE if math.isnan(minutes) else f"{minutes:.0f} min",
        ", ".join(f"{100 * run['curve'][-1]['success']:.0f}" for run in runs),
        ", ".join("yes" if run["flattened"] else "**no**" for run in runs),
    ]


def decision_costs(settings: Settings, costs: Mapping[str, Mapping[str, float]]) -> str:
    """Return the cost of decisions."""
    lines = []
    for name, agent in settings.agents.items():
        own = [costs[key] for key in (f"{worlds}/{name}" for worlds in settings.worlds) if key in costs]
        if own:
            episodes = sum(one.get("episodes", math.nan) for one in own)
            count = sum(one["decisions"] for one in own)
            mean = sum(one["mean_ms"] * one["decisions"] for one in own) / count
            longest = max(one["longest_ms"] for one in own)
            timed = NONE if math.isnan(episodes) else f"{episodes:,.0f}"
            lines.append([agent.title, timed, f"{count:,.0f}", f"{mean:,.1f}", f"{longest:,.0f}"])
    head = ["agent", "episodes timed", "decisions", "mean, ms", "longest of an episode, ms"]
    return table_or_nothing(head, lines) or "Not recorded."
