"""Pages of the effects: law, figure, detection limit, push, parameters and source."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import trundle
from trundle.cli.commands.effects import format_prior
from trundle.experiments.markdown import table
from website.benchmark_tables import DETECTION_PAGE, correct_answers, detection
from website.effect_figure import changes_motion, draw_effect
from website.effect_push import effect_values
from website.rust_source import law, suggested_push

__all__ = ["effect_page", "effect_pages"]

ACTS_ON = {"object": "the object", "instrument": "the instruments"}


def effect_pages() -> Iterator[tuple[str, str]]:
    """Yield path and text of the index and of the page of each effect."""
    catalogue = trundle.effects()
    yield "effects/index.md", index_page(catalogue)
    for effect in catalogue:
        yield f"effects/{effect['kind']}.md", effect_page(effect)


def index_page(catalogue: list[dict[str, Any]]) -> str:
    """Return the list of all effects."""
    parts = [
        "# Effects",
        "Every effect that a model can contain. Each page shows the law, what it looks like in a residual, "
        "its detection limit, the push that shows it, and its parameters. "
        "[Implementation notes](../effects.md) cover states and integration. `trundle effects` prints the "
        "same catalogue.",
    ]
    for target, name in ACTS_ON.items():
        rows = [
            [f"[`{one['kind']}`]({one['kind']}.md)", one["summary"], limit_cell(one)]
            for one in catalogue
            if one["acting"] == target
        ]
        parts += [
            f"## Effects on {name}",
            table(["effect", "summary", "smallest relative size that is named"], rows),
        ]
    return "\n\n".join(parts) + "\n"


def limit_cell(effect: dict[str, Any]) -> str:
    """Return the detection limit of an effect for the list."""
    found = detection(effect["effect"])
    return "not measured" if found is None else size_text(effect, found.smallest)


def size_text(effect: dict[str, Any], smallest: str) -> str:
    """Return the smallest size that is named, with the units of its values."""
    relative, _, values = smallest.partition(":")
    if not values.strip():
        return relative
    units = {one["name"]: one["unit"].replace("1", "") for one in effect["parameters"]}
    named = [value.rsplit(" ", 1) for value in values.strip().split(", ")]
    shown = ", ".join(f"{name} {value} {units.get(name, '')}".strip() for name, value in named)
    return f"{relative} ({shown})"


def effect_page(effect: dict[str, Any]) -> str:
    """Return the page of an effect."""
    kind = effect["kind"]
    sections = [
        f"# {kind}",
        f"**{sentence(effect['summary'])}**",
        facts(effect),
        f"## Law\n\n{law(kind)}",
        f"## In a residual\n\n{residual_text(effect)}",
        f"## Push that shows it\n\n{sentence(suggested_push(kind))}",
        f"## Detection\n\n{detection_text(effect)}",
        f"## Parameters\n\n{parameter_table(effect)}",
        f"## In a model\n\n{example(effect)}",
    ]
    return "\n\n".join(sections) + "\n"


def sentence(text: str) -> str:
    """Return text as a sentence."""
    return f"{text[0].upper()}{text[1:].rstrip('.')}."


def facts(effect: dict[str, Any]) -> str:
    """Return the properties of an effect as a table."""
    states = ", ".join(f"{state['name']} ({state['unit']})" for state in effect["states"]) or "none"
    rows = [
        ["name in a diagnosis", f"`{effect['effect']}`"],
        ["acts on", ACTS_ON[effect["acting"]]],
        ["dissipative", "yes" if effect["dissipative"] else "no"],
        ["internal states", states],
        ["sentence", effect["sentence"].replace("{", "*").replace("}", "*")],
        ["source", effect["source"]],
    ]
    return table(["property", "value"], rows)


def residual_text(effect: dict[str, Any]) -> str:
    """Return the figure of an effect with an explanation."""
    values = ", ".join(f"{name} {value:g}" for name, value in effect_values(effect).items())
    left = (
        "The left panel shows the path of the object from above; the dotted outline is the start, crosses "
        "are places of the effect."
        if changes_motion(effect)
        else "The effect does not change the motion; the left panel shows how it changes the reading."
    )
    return (
        f"{draw_effect(effect)}\n\n"
        "The same push of an office table (22 kg, one locked wheel) is simulated with and without the "
        f"effect, without noise. {left} The right panels show the wrench that would have to act in addition "
        "for the model without the effect to move as recorded, in object axes about the object's "
        "origin.\n\n"
        f"Values in the figure: {values}."
    )


def detection_text(effect: dict[str, Any]) -> str:
    """Return how reliably a diagnosis names an effect, from the blind benchmarks."""
    found, answers = detection(effect["effect"]), correct_answers(effect["effect"])
    if found is None:
        parts = ["The detection limit is not measured."]
    else:
        head = ["relative size", *found.counts]
        parts = [
            f"Named recordings by size, relative to a size that improves predictions threefold "
            f"([details](../{DETECTION_PAGE}#detection-limits)):",
            table(head, [["named", *found.counts.values()]]),
            f"Smallest relative size named in 95 %: {size_text(effect, found.smallest)}.",
        ]
    if answers:
        rows = [[f"[{name}](../{page})", share] for page, name, share in answers]
        parts += [
            "Correct answers if it is the only hidden effect (interval of 95 %):",
            table(["benchmark", "correct"], rows),
        ]
    else:
        parts.append("No blind benchmark hides this effect alone.")
    return "\n\n".join(parts)


def parameter_table(effect: dict[str, Any]) -> str:
    """Return the parameters with units, bounds and priors."""
    rows = [
        [
            f"`{one['name']}`",
            one["unit"],
            f"{one['lower']:.6g} to {one['upper']:.6g}",
            "–" if one["neutral"] is None else f"{one['neutral']:g}",
            "free" if one["default"] is None else f"{one['default']:g}",
            format_prior(one["prior"]),
            one["help"],
        ]
        for one in effect["parameters"]
    ]
    head = ["parameter", "unit", "bounds", "no effect at", "default", "prior", "meaning"]
    return table(head, rows)


def example(effect: dict[str, Any]) -> str:
    """Return the table of an effect in a `model.toml`."""
    values = "\n".join(f"{name} = {value}" for name, value in effect_values(effect).items())
    return (
        f'```toml\n[[effect]]\nkind = "{effect["kind"]}"\n{values}\n```\n\n'
        "A parameter without a value is estimated, or takes its default."
    )
