"""`trundle design`: discriminating experiments (optimal experiment design)."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from trundle.cli.options import add_out, add_quiet
from trundle.cli.paths import Input, Output, declare
from trundle.progress import Progress

if TYPE_CHECKING:
    from trundle.design import Design

HELP = "Find the pushes that best discriminate two models."
EXAMPLE = "trundle design slope.toml bias.toml --object recording/ --out design/"

LIMITS = {
    "force": ("N", "maximum force at the grasp, N (default: as recorded, or 30)"),
    "torque": ("NM", "maximum torque at the grasp, N·m (default: as recorded, or 8)"),
    "duration": ("S", "time in contact, s (default: as recorded, or 6)"),
    "speed": ("V", "maximum speed of the object, m/s (default: as recorded, or 0.6)"),
    "spin": ("W", "maximum angular velocity of the object, rad/s (default: as recorded, or 1)"),
    "distance": ("M", "maximum displacement of the object, m (default: as recorded, or 1.2)"),
}
"""Limits of a push: option, metavar, help."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the two models, the object, the noise, the limits and the output folder."""
    text = "first model.toml; fitted if there is a recording, otherwise it must contain all values"
    parser.add_argument("model_a", metavar="MODEL_A", type=Path, help=text)
    parser.add_argument("model_b", metavar="MODEL_B", type=Path, help="second model.toml")
    for name in ("model_a", "model_b"):
        declare(parser, name, Input(name.upper(), "file", "a model file (model.toml)"))
    parser.add_argument(
        "--object",
        metavar="PATH",
        type=Path,
        help="recording of the object, to which both models are fitted, or a file with its [body] "
        "(default: the body of MODEL_A)",
    )
    declare(parser, "object", Input("--object", "any"))
    parser.add_argument(
        "--noise",
        metavar=("POSITION", "HEADING", "FORCE", "TORQUE"),
        type=float,
        nargs=4,
        default=None,
        help="standard deviations, used without a recording: m, rad, N, N·m "
        "(default 0.0005 0.00175 0.4 0.05)",
    )
    parser.add_argument(
        "--pushes",
        metavar="N",
        type=int,
        default=1,
        help="number of pushes; each is the best in addition to the previous ones (default 1)",
    )
    for name, (metavar, help) in LIMITS.items():
        parser.add_argument(f"--{name}", metavar=metavar, type=float, default=None, help=help)
    add_out(
        parser,
        "folder for design.json and, if the models can be simulated, scenario.toml and object.toml",
        Output("--out", "folder"),
    )
    parser.add_argument("--json", action="store_true", help="print the design as JSON")
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Design the pushes, print them and write the files."""
    from trundle.design import DEFAULT_NOISE_SD, design

    recorded = args.object is not None and args.object.is_dir()
    with Progress(f"designing for {args.model_a} and {args.model_b}", quiet=args.quiet) as progress:
        found = design(
            args.model_a,
            args.model_b,
            recording=args.object if recorded else None,
            object=None if recorded else args.object,
            noise=DEFAULT_NOISE_SD if args.noise is None else tuple(args.noise),
            pushes=args.pushes,
            **{name: getattr(args, name) for name in LIMITS},
            progress=progress.share,
        )
    for warning in found.warnings:
        print(f"trundle: warning: {warning}", file=sys.stderr)
    print(found.to_json() if args.json else "\n".join(format_design(found)))
    if args.out is not None:
        found.write(args.out)
    return 0


def format_design(found: Design) -> list[str]:
    """Format a design for the terminal."""
    rows = [found.sentence]
    if abs(found.recorded) >= 0.5:
        first, second = found.models if found.recorded > 0 else found.models[::-1]
        rows.append(f"  so far the recording prefers {first} to {second} by {abs(found.recorded):.1f} nats")
    elif found.recorded:
        rows.append("  so far the recording prefers neither")
    if len(found.pushes) > 1:
        rows += [
            f"  push {k + 1}: {push.separation:.3g} nats, {push.cumulative:.3g} nats with the previous pushes"
            for k, push in enumerate(found.pushes)
        ]
    return rows
