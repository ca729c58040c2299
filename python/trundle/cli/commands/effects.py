"""`trundle effects`: the catalogue of physical effects that a model can hold."""

from __future__ import annotations

import argparse
import json
import textwrap
from typing import Any

HELP = "List every effect that a model can hold, with its parameters."
EXAMPLE = "trundle effects --json"

LINE_WIDTH = 100


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare `--json`."""
    parser.add_argument("--json", action="store_true", help="print the catalogue for programs")


def run(args: argparse.Namespace) -> int:
    """Print the catalogue."""
    import trundle

    catalogue = trundle.effects()
    if args.json:
        print(json.dumps(catalogue, indent=2, ensure_ascii=False))
    else:
        print("\n\n".join(map(format_effect, catalogue)))
    return 0


def format_effect(effect: dict[str, Any]) -> str:
    """Return one effect as a paragraph and a table of its parameters."""
    named = "" if effect["effect"] == effect["kind"] else f" (diagnosed as {effect['effect']})"
    lines = [f"{effect['kind']}{named}", *wrap(effect["summary"]), *wrap(f"Source: {effect['source']}")]
    rows = [table_row(parameter) for parameter in effect["parameters"]]
    table = [("parameter", "unit", "bounds", "neutral", "if left out", "prior"), *(row[:-1] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    layout = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in table]
    lines.append(f"    {layout[0]}")
    for text, row in zip(layout[1:], rows, strict=True):
        lines += [f"    {text}", *wrap(row[-1], indent=6)]
    return "\n".join(lines)


def wrap(text: str, indent: int = 2) -> list[str]:
    """Return `text` in indented lines."""
    return textwrap.wrap(text, LINE_WIDTH, initial_indent=" " * indent, subsequent_indent=" " * indent)


def table_row(parameter: dict[str, Any]) -> tuple[str, ...]:
    """Return a parameter's row of the table, and what it is."""
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


def format_prior(belief: dict[str, Any]) -> str:
    """Return a prior in words."""
    match belief["distribution"]:
        case "normal":
            return f"normal, mean {belief['mean']:g}, sd {belief['sd']:g}"
        case "log_normal":
            return f"log-normal, median {belief['median']:g}, sd {belief['sd']:g} e-folds"
        case "on_body":
            return f"uniform over the body along {belief['axis']}"
        case "uniform":
            return "uniform between its bounds"
        case _:
            return f"uniform, period {belief['period']:.5g}"
