"""`trundle diagnose`: where a recording and a simulation differ, and which effects are missing."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from trundle.cli.options import (
    add_backend,
    add_mjcf,
    add_model,
    add_quiet,
    add_seed,
    select_backend,
)
from trundle.cli.paths import DIAGNOSIS, Input, check_output, declare
from trundle.cli.simulator import Simulator, add_simulator, select_simulator
from trundle.progress import Progress

if TYPE_CHECKING:
    from trundle._types import JointAnswer

HELP = "Locate where a simulation differs from a recording, and name the missing effects."
EXAMPLE = "trundle diagnose recording/ --out diagnosis/table"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the recordings, the model, the settings and the output folder."""
    parser.add_argument(
        "recording",
        metavar="RECORDING",
        type=Path,
        nargs="+",
        help="recording: a folder with recording.toml, or with --mjcf or --step a CSV log of joints",
    )
    declare(parser, "recording", Input("RECORDING", "log"))
    add_model(parser)
    add_mjcf(parser, "MJCF or URDF file of a mechanism, which replaces that of the recording")
    add_simulator(parser)
    parser.add_argument(
        "--out",
        metavar="PATH",
        type=Path,
        help="output folder (default diagnosis/NAME); with several recordings it has one subfolder for each",
    )
    parser.add_argument(
        "--without",
        action="append",
        default=[],
        metavar="EFFECT",
        help="do not test this effect; may be repeated",
    )
    parser.add_argument(
        "--wrench-pose",
        choices=("own_time", "latest"),
        default="own_time",
        help="pose that transforms each wrench to the object: own_time: the one at the time of the wrench "
        "(default); latest: the latest recorded one (equation 13 of the paper)",
    )
    parser.add_argument(
        "--no-check",
        action="store_true",
        help="accept a recording whose units, sign, axes or clocks appear wrong (see `trundle check`)",
    )
    add_backend(parser)
    add_seed(parser)
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Diagnose each recording and write its output folder."""
    from trundle.experiments.backends import Local, in_order

    simulator = select_simulator(args)
    check_outputs(args)
    where = select_backend(args)
    quiet = args.quiet or where != Local(1)  # parallel progress lines would overlap
    shared = (
        args.model,
        args.mjcf,
        simulator,
        args.seed,
        args.without,
        args.wrench_pose,
        not args.no_check,
        quiet,
    )
    calls = [(path, output_folder(path, args), command_line(path, args), *shared) for path in args.recording]
    refused = []
    for answer in in_order(where, diagnose_one, calls):
        if isinstance(answer, str):
            refused.append(answer)
            continue
        warnings, text = answer
        for warning in warnings:
            print(f"trundle: warning: {warning}", file=sys.stderr)
        print(text, flush=True)
    if refused:
        raise ValueError("\n".join(refused))
    return 0


def check_outputs(args: argparse.Namespace) -> None:
    """Check the output folder of each recording before the first diagnosis."""
    inputs = dict.fromkeys(args.recording, "RECORDING")
    folders: dict[Path, Path] = {}
    for recording in args.recording:
        folder = output_folder(recording, args)
        check_output(folder, DIAGNOSIS, inputs)
        if folder in folders:
            raise ValueError(
                f"{folder}: would be the output of both {folders[folder]} and {recording}; diagnose them one "
                "by one with different --out"
            )
        folders[folder] = recording


def diagnose_one(
    recording: Path,
    folder: Path,
    line: str,
    model: Path | None,
    mjcf: Path | None,
    simulator: Simulator | None,
    seed: int,
    without: list[str],
    wrench_pose: Literal["own_time", "latest"],
    check: bool,
    quiet: bool,
) -> tuple[list[str], str] | str:
    """Diagnose one recording and write its output folder.

    Returns
    -------
    tuple or str
        Warnings and the formatted answer; if the recording is refused, the error message instead.
    """
    import trundle

    try:
        black_box = {} if simulator is None else simulator.load()
        with Progress(f"diagnosing {recording}", quiet=quiet) as progress:
            diagnosis = trundle.diagnose(
                recording,
                model,
                mjcf=mjcf,
                **black_box,
                seed=seed,
                without=without,
                wrench_pose=wrench_pose,
                check=check,
                progress=progress.share,
                command=line,
            )
        written = diagnosis.write(folder)
    except trundle.TrundleError as error:
        return str(error)
    if isinstance(diagnosis, trundle.JointDiagnosis):
        lines = format_joint_answer(diagnosis.answer, written)
        columns = diagnosis.recording.metadata.get("notes", {}).get("columns")
        if recording.suffix.lower() == ".csv" and columns:
            lines.insert(1, f"  columns: {columns}")
        return diagnosis.answer["warnings"], "\n".join(lines)
    return diagnosis.series["doubts"], "\n".join(format_answer(diagnosis.answer, written))


def output_folder(recording: Path, args: argparse.Namespace) -> Path:
    """Return the output folder of a recording."""
    name = recording.resolve().name
    if recording.suffix.lower() == ".csv":
        name = recording.stem
    if args.out is None:
        return Path("diagnosis") / name
    return Path(args.out) if len(args.recording) == 1 else Path(args.out) / name


def command_line(recording: Path, args: argparse.Namespace) -> str:
    """Return the command line that reproduces the diagnosis of a recording."""
    words = ["trundle", "diagnose", str(recording)]
    if args.model is not None:
        words += ["--model", str(args.model)]
    if args.mjcf is not None:
        words += ["--mjcf", str(args.mjcf)]
    simulator = select_simulator(args)
    if simulator is not None:
        words += simulator.words
    for effect in args.without:
        words += ["--without", effect]
    if args.wrench_pose != "own_time":
        words += ["--wrench-pose", args.wrench_pose]
    if args.no_check:
        words.append("--no-check")
    return shlex.join([*words, "--seed", str(args.seed)])


def format_answer(answer: Mapping[str, Any], folder: Path) -> list[str]:
    """Format a diagnosis for the terminal."""
    from trundle.report.verdict import headline

    found = [f"{answer['recording']}: {answer['verdict']}"]
    found += [] if answer["missing"] else [f"  {headline(answer)}"]
    for effect in answer["missing"]:
        found.append(f"  {effect['effect']} (probability {effect['probability']:.2f}): {effect['statement']}")
    found += [
        f"  detectable but immaterial, not corrected: {effect['effect']}"
        for effect in answer.get("immaterial", [])
    ]
    found += [f"  indistinguishable: {', '.join(names)}" for names in answer["tied"]]
    found += format_held_out(answer["fit"]["held_out"], METRICS)
    return [*found, f"  report: {folder / 'report.html'}"]


def format_joint_answer(answer: JointAnswer, folder: Path) -> list[str]:
    """Format a diagnosis of joints for the terminal."""
    from trundle.joint_diagnosis.symptoms import headline, symptoms

    found = [f"{answer['recording']}: {answer['verdict']}"]
    found += [] if answer["missing"] else [f"  {headline(answer)}"]
    found += [f"  {name}: {text}" for name, text in symptoms(answer)]
    for effect in answer["missing"]:
        name = ":".join([effect["effect"], *(effect["where"] or {}).values()])
        found.append(f"  {name} (probability {effect['probability']:.2f}): {effect['statement']}")
    for effect in answer["immaterial"]:
        name = ":".join([effect["effect"], *(effect["where"] or {}).values()])
        found.append(f"  detectable but immaterial, not corrected: {name}")
    found += [f"  indistinguishable: {', '.join(names)}" for names in answer["tied"]]
    found += format_held_out(answer["fit"]["held_out"], JOINT_METRICS)
    return [*found, f"  report: {folder / 'report.html'}"]


JOINT_METRICS = {
    "relative_position_rmse": "position, open loop, share of the range: {before:.4f} -> {after:.4f}",
    "relative_window_rmse": "position, one second ahead, share of the range: {before:.5f} -> {after:.5f}",
    "relative_effort_rmse": "required minus recorded effort, share of the range: {before:.4f} -> {after:.4f}",
}
"""Metrics of mechanisms on held-out data: key of diagnosis.json, format."""
METRICS = {
    "position_rmse": "position, open loop: {before:.4f} -> {after:.4f} m",
    "window_position_rmse": "position, one second ahead: {before:.5f} -> {after:.5f} m",
    "force_rmse": "required minus recorded force: {before:.3f} -> {after:.3f} N",
    "torque_rmse": "required minus recorded torque: {before:.4f} -> {after:.4f} N·m",
}
"""Metrics on held-out data: key of diagnosis.json, format."""


def format_held_out(pair: Any, metrics: Mapping[str, str]) -> list[str]:
    """Return a line for each metric on held-out data, or one that says that there are none."""
    if not pair:
        return [
            "  no episode is held out: add [split] held_out to recording.toml to measure errors on new data"
        ]
    lines = [format_metric(pair, key, text) for key, text in metrics.items()]
    return [f"  held out, {line}" for line in lines if line]


def format_metric(pair: dict[str, dict[str, float | None]], key: str, text: str) -> str:
    """Format a metric before and after; return an empty string if it is absent."""
    before, after = pair["before"][key], pair["after"][key]
    return "" if before is None or after is None else text.format(before=before, after=after)
