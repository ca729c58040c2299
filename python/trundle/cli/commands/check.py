"""`trundle check`: what is wrong with a recording, before any physics."""

from __future__ import annotations

import argparse
import json
import textwrap
from typing import Any

from trundle.cli.exits import USAGE
from trundle.cli.options import add_recording

HELP = "Look for wrong units, signs, axes, clocks and tares in a recording, and for too little motion."
EXAMPLE = "trundle check recording/"

LINE_WIDTH = 100


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the recording, `--json` and `--strict`."""
    add_recording(parser)
    parser.add_argument("--json", action="store_true", help="print the findings for programs")
    parser.add_argument("--strict", action="store_true", help="exit with status 2 if an error was found")


def run(args: argparse.Namespace) -> int:
    """Print the findings, the gravest first."""
    import trundle

    findings = trundle.check(args.recording)
    print(
        json.dumps(findings, indent=2, ensure_ascii=False)
        if args.json
        else "\n".join(format_findings(findings))
    )
    failed = any(finding["severity"] == "error" for finding in findings)
    return USAGE if args.strict and failed else 0


def format_findings(findings: list[dict[str, Any]]) -> list[str]:
    """Return the findings as text."""
    if not findings:
        return ["nothing found: units, sign, axes, clocks, tare and motion look right"]
    return [line for finding in findings for line in format_finding(finding)]


def format_finding(finding: dict[str, Any]) -> list[str]:
    """Return one finding as a paragraph: what is seen, and what to do."""
    where = "" if finding["episode"] is None else f" {finding['episode']}:"
    seen = f"{finding['severity']} ({finding['kind']}):{where} {finding['sentence']}"
    return [*wrap(seen, ""), *wrap(finding["remedy"], "    → ")]


def wrap(text: str, lead: str) -> list[str]:
    """Return `text` in lines, the first after `lead`."""
    return textwrap.wrap(text, LINE_WIDTH, initial_indent=lead, subsequent_indent="    ")
