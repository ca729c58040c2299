"""Tables of a comparison's document."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

import trundle
from trundle.experiments.comparison.config import Settings, Target, Worlds
from trundle.experiments.comparison.curves import Curve
from trundle.experiments.comparison.results import Results
from trundle.experiments.comparison.scores import (
    MAX_QUICK_PUSHES,
    negative_return,
    quick_success,
    regret,
    regret_iqm,
    scores,
    success,
    time_to_success,
)
from trundle.experiments.markdown import table
from trundle.experiments.results import Row
from trundle.experiments.statistics import Estimate, difference, improvement, iqm, rate

__all__ = [
    "decision_costs",
    "diagnoses",
    "learning",
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


def percent(found: Estimate, form: str = ".1f") -> str:
    """Return a share and its interval in percent."""
    return found.text(form, 100.0, " %")


def outcomes(settings: Settings, group: Mapping[str, Rows]) -> str:
    """Return the outcomes of the episodes of a group of worlds."""
    lines = [
        [
            settings.agents[name].title,
            *outcome_cells(rows, settings.push if settings.agents[name].learns else None),
        ]
        for name, rows in group.items()
        if rows
    ]
    head = ["agent", "success", f"after ≤ {MAX_QUICK_PUSHES} learning pushes", "lost", "collision"]
    return table([*head, "remaining distance / radius", "remaining heading error, °"], lines)


def outcome_cells(rows: Rows, push: float | None) -> list[str]:
    """Return the outcomes of an agent's episodes; `push` is the push duration, s, of a learning agent."""
    return [
        percent(success(rows)),
        NONE if push is None else percent(quick_success(rows, push)),
        percent(rate(scores(rows, lambda row: row["lost"]))),
        percent(rate(scores(rows, lambda row: row["touches"] > 0))),
        iqm(scores(rows, lambda row: row["distance"] / row["radius"])).text(".3f"),
        iqm(scores(rows, lambda row: row["heading"])).text(".1f", 57.29578),
    ]


def regret_table(settings: Settings, group: Mapping[str, Rows]) -> str:
    """Return the time and the regret relative to the oracle in a group of worlds."""
    oracle = oracle_rows(settings, group)
    lines = []
    for name, rows in group.items():
        if rows:
            both: list[Callable[..., Estimate]] = [regret_iqm, regret]
            beside = [percent(one(rows, oracle, negative_return), ".0f") if oracle else NONE for one in both]
            beside.append(percent(regret(rows, oracle, time_to_success), ".0f") if oracle else NONE)
            time = iqm(scores(rows, time_to_success))
            pushes = f"{time.value / settings.push:.0f}"
            learns = settings.agents[name].learns
            fits = iqm(scores(rows, lambda row: row["fits"])).text(".1f") if learns else NONE
            lines.append([settings.agents[name].title, time.text(".1f"), pushes, fits, *beside])
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
        rows, oracle = group.get(target.agent, []), oracle_rows(settings, group)
        if not rows or (target.figure == "regret" and not oracle):
            continue
        match target.figure:
            case "success":
                found = success(rows)
            case "quick success":
                found = quick_success(rows, settings.push)
            case "regret":
                found = regret(rows, oracle)
        who = [f"`{target.worlds}`", settings.agents[target.agent].title]
        lines.append([*who, target.figure, *target_cells(target, found)])
    return table(["worlds", "agent", "figure", "target", "result", ""], lines) if lines else ""


def target_cells(target: Target, found: Estimate) -> list[str]:
    """Return a target, the result, and whether the result meets the target."""
    if target.least is not None:
        least = target.least
        said, meets, surely = f"≥ {100 * least:g} %", found.value >= least, found.low >= least
    else:
        most = target.most or 0.0  # one of the two is given
        said, meets, surely = f"≤ {100 * most:g} %", found.value <= most, found.high <= most
    return [
        said,
        percent(found),
        "met" if surely else "met, interval reaches beyond" if meets else "**not met**",
    ]


def paired_differences(settings: Settings, results: Results) -> str:
    """Return the differences between the agents of each pair."""
    lines = []
    for first, second in settings.pairs:
        for name, group in results.items():
            a, b = group.get(first), group.get(second)
            if a and b:
                who = f"{settings.agents[first].title} over {settings.agents[second].title}"
                lines.append([who, f"`{name}`", *difference_cells(a, b)])
    head = [
        "pair",
        "worlds",
        "success, percentage points",
        "cost, sums",
        "probability of better return",
        "time, sums",
    ]
    return table(head, lines) if lines else ""


def difference_cells(a: Rows, b: Rows) -> list[str]:
    """Return the differences between two agents."""
    return [
        difference(*(scores(rows, lambda row: row["success"]) for rows in (a, b))).text("+.1f", 100.0),
        percent(regret(a, b, negative_return), "+.0f"),
        percent(improvement(*(scores(rows, lambda row: row["return"]) for rows in (a, b))), ".0f"),
        percent(regret(a, b, time_to_success), "+.0f"),
    ]


def diagnoses(settings: Settings, results: Results) -> str:
    """Return the effects that diagnosing agents named."""
    lines = []
    for name, group in results.items():
        hidden = hidden_effects(settings.worlds[name])
        for agent, rows in group.items():
            if rows and settings.agents[agent].settings.get("diagnose"):
                lines.append([f"`{name}`", settings.agents[agent].title, *naming_cells(rows, hidden)])
    head = ["worlds", "agent", "correct name", "wrong name"]
    return table(head, lines) if lines else ""


def hidden_effects(worlds: Worlds) -> set[str] | None:
    """Return the hidden effects besides a wheel, by the names of diagnoses; None if worlds differ in them."""
    fixed = {f"trundle/{task.__name__}-v0": task.FIXED.get("hidden") for task in trundle.envs.FLAT}
    drawn = worlds.options.get("hidden", fixed.get(worlds.env))
    if drawn not in ("none", "locked"):
        return None
    names = {law["kind"]: law["effect"] for law in trundle.effects()}
    laws = [*worlds.options.get("effects", []), *worlds.effect]
    told = [names[law["kind"]] for law in laws if law.get("kind") in names]
    wheels = told.count(OWN_WHEEL) + (drawn == "locked")
    return {*told, *([SECOND_WHEEL] if wheels > 1 else [])} - {OWN_WHEEL}


def naming_cells(rows: Rows, hidden: set[str] | None) -> list[str]:
    """Return the rates of correct and of wrong names."""
    if hidden is None:
        return [NONE, NONE]
    right = rate(scores(rows, lambda row: bool(hidden & set(row["named"]))))
    wrong = rate(scores(rows, lambda row: bool(set(row["named"]) - hidden)))
    return [percent(right) if hidden else NONE, percent(wrong)]


def learning(settings: Settings, results: Results, curves: Mapping[str, Sequence[Curve]]) -> str:
    """Return the training cost and the final result of each policy."""
    playing = {agent for group in results.values() for agent, rows in group.items() if rows}
    lines = []
    for name, agent in settings.agents.items():
        mine = curves.get(agent.curve, [])
        if name in playing and mine:
            lines.append([agent.title, str(len(mine)), *training_cells(mine)])
    head = ["policy", "runs", "parameters", "steps of each", "simulated", "CPU time", "success at the end, %"]
    return table([*head, "flattened"], lines) if lines else ""


def training_cells(runs: Sequence[Curve]) -> list[str]:
    """Return the cost of a policy's training runs, and their results."""
    first = runs[0]
    simulated, cpu = (np.array([getattr(one, name) for one in runs]) for name in ("simulated", "cpu"))
    return [
        f"{first.parameters:,}",
        f"{first.steps[-1]:,.0f}",
        f"{simulated.mean() / 3600:.1f} h",
        f"{cpu.mean() / 60:.0f} min" if np.isfinite(cpu).all() else NONE,
        ", ".join(f"{100 * one.success[-1]:.0f}" for one in runs),
        ", ".join("yes" if one.flattened else "**no**" for one in runs),
    ]


def decision_costs(settings: Settings, costs: Mapping[str, Mapping[str, float]]) -> str:
    """Return the cost of decisions."""
    lines = []
    for name, agent in settings.agents.items():
        mine = [costs[key] for key in (f"{worlds}/{name}" for worlds in settings.worlds) if key in costs]
        if mine:
            count = sum(one["decisions"] for one in mine)
            episodes = sum(one.get("episodes", np.nan) for one in mine)
            mean = sum(one["mean_ms"] * one["decisions"] for one in mine) / count
            longest = max(one["longest_ms"] for one in mine)
            lines.append(
                [
                    agent.title,
                    NONE if np.isnan(episodes) else f"{episodes:,.0f}",
                    f"{count:,.0f}",
                    f"{mean:,.1f}",
                    f"{longest:,.0f}",
                ]
            )
    return (
        table(["agent", "episodes timed", "decisions", "mean, ms", "longest of an episode, ms"], lines)
        if lines
        else "Not recorded."
    )


def policy_comparison(settings: Settings, results: Results) -> str:
    """Return the differences between trained policies and the main agent."""
    lines = []
    for name, group in results.items():
        main = group.get(settings.main)
        for agent, rows in group.items():
            if main and rows and settings.agents[agent].kind == "policy":
                lines.append([f"`{name}`", settings.agents[agent].title, *difference_cells(rows, main)])
    head = [
        "worlds",
        "policy",
        "success, percentage points",
        "cost, sums",
        "probability of better return",
        "time, sums",
    ]
    return table(head, lines) if lines else ""
