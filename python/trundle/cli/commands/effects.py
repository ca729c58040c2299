"""`trundle effects`: the catalogue of physical effects."""

from __future__ import annotations

import argparse
import json
import textwrap
from collections.abc import Mapping
from typing import Any

HELP = "List the effects that a model can contain, with their parameters."
EXAMPLE = "trundle effects --json"

LINE_WIDTH = 100


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add `--json`."""
    parser.add_argument("--json", action="store_true", help="print the catalogue as JSON")


def run(args: argparse.Namespace) -> int:
    """Print the catalogue."""
    import trundle

    catalogue, joints = trundle.effects(), trundle.joint_effects()
    if args.json:
        print(json.dumps([*catalogue, *joints], indent=2, ensure_ascii=False))
    else:
        print("\n\n".join([*map(format_effect, catalogue), JOINTS, *map(format_joint_effect, joints)]))
    return 0


JOINTS = "Effects of mechanisms (recordings of joints); units are those of a hinge."
"""Heading of the second part of the catalogue."""


def format_joint_effect(effect: Mapping[str, Any]) -> str:
    """Format an effect of a mechanism as a paragraph and a list of its parameters."""
    parameters = ", ".join(f"{one['name']} ({one['unit'] or '1'})" for one in effect["parameters"])
    texts = (effect["summary"], f"Source: {effect['source']}", f"Parameters: {parameters}")
    return "\n".join([effect["effect"], *(line for text in texts for line in wrap(text))])


def format_effect(effect: dict[str, Any]) -> str:
    """Format an effect as a paragraph and a table of its parameters."""
    named = "" if effect["effect"] == effect["kind"] else f" (diagnosed as {effect['effect']})"
    lines = [f"{effect['kind']}{named}", *wrap(effect["summary"]), *wrap(f"Source: {effect['source']}")]
    rows = [table_row(parameter) for parameter in effect["parameters"]]
    table = [("parameter", "unit", "bounds", "neutral", "default", "prior"), *(row[:-1] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    layout = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in table]
    lines.append(f"    {layout[0]}")
    for text, row in zip(layout[1:], rows, strict=True):
        lines += [f"    {text}", *wrap(row[-1], indent=6)]
    return "\n".join(lines)


def wrap(text: str, indent: int = 2) -> list[str]:
    """Wrap `text` with an indent."""
    return textwrap.wrap(text, LINE_WIDTH, initial_indent=" " * indent, subsequent_indent=" " * indent)


def table_row(parameter: dict[str, Any]) -> tuple[str, ...]:
    """Return the cells of a parameter, and its description as the last entry."""
    default = parameter["default"]
    return (
        parameter["name"],
        parameter["unit"],
        f"[{parameter['lower']:.6g}, {parameter['upper']:.6g}]",
        "-" if parameter["neutral"] is None else f"{parameter['neutral']:g}",
        "free" if default is None else f"{default:g}",
        format_prior(parameter["prior"]),
        parameter["help"],
    )


def format_prior(prior: dict[str, Any]) -> str:
    """Format a prior distribution."""
    match prior["distribution"]:
        case "normal":
            return f"normal, mean {prior['mean']:g}, sd {prior['sd']:g}"
        case "log_normal":
            return f"log-normal, median {prior['median']:g}, sd {prior['sd']:g} e-folds"
        case "on_body":
            return f"uniform over the body along {prior['axis']}"
        case "uniform":
            return "uniform between its bounds"
        case _:
            return f"uniform, period {prior['period']:.5g}"
