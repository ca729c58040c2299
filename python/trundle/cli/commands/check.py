"""`trundle check`: errors in a recording that can be found without a model."""

from __future__ import annotations

import argparse
import json
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

from trundle.cli.exits import USAGE
from trundle.cli.options import add_mjcf
from trundle.cli.paths import Input, declare

if TYPE_CHECKING:
    from trundle.findings import Finding, Findings

HELP = "Check a recording for wrong units, signs, axes, clocks and tares, and for insufficient motion."
EXAMPLE = "trundle check recording/"

LINE_WIDTH = 100


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the recording, its model, `--json` and `--strict`."""
    parser.add_argument(
        "recording",
        metavar="RECORDING",
        type=Path,
        help="recording: a folder with recording.toml, or a CSV log of joints",
    )
    declare(parser, "recording", Input("RECORDING", "log"))
    add_mjcf(parser, "MJCF or URDF file, which names the joints of a CSV log")
    parser.add_argument("--json", action="store_true", help="print the findings as JSON")
    parser.add_argument("--strict", action="store_true", help="exit with status 2 if an error is found")


def run(args: argparse.Namespace) -> int:
    """Print the findings, most severe first."""
    import trundle
    from trundle.findings import Findings
    from trundle.input_checks import held_out_findings
    from trundle.joint_diagnosis.log import open_log

    log = open_log(args.recording, args.mjcf)
    recording = trundle.read(args.recording) if log is None else log
    findings = Findings([*trundle.check(recording), *held_out_findings(recording)])
    print(
        json.dumps([finding.to_dict() for finding in findings], indent=2, ensure_ascii=False)
        if args.json
        else "\n".join(format_findings(findings))
    )
    return USAGE if args.strict and findings.errors else 0


def format_findings(findings: Findings) -> list[str]:
    """Format the findings as lines."""
    if not findings:
        return ["nothing found: units, sign, axes, clocks, tare and motion look right"]
    return [line for finding in findings for line in format_finding(finding)]


def format_finding(finding: Finding) -> list[str]:
    """Format one finding as a paragraph: the observation and the remedy."""
    where = "" if finding.episode is None else f" {finding.episode}:"
    observation = f"{finding.severity} ({finding.kind}):{where} {finding.sentence}"
    return [*wrap(observation, ""), *wrap(finding.remedy, "    → ")]


def wrap(text: str, lead: str) -> list[str]:
    """Wrap `text`; the first line begins with `lead`."""
    return textwrap.wrap(text, LINE_WIDTH, initial_indent=lead, subsequent_indent="    ")
