"""`trundle design`: discriminating experiments for objects and joints (optimal experiment design)."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trundle.cli.options import add_mjcf, add_out, add_quiet
from trundle.cli.paths import Input, Output, declare
from trundle.progress import Progress

if TYPE_CHECKING:
    from trundle.design import Design
    from trundle.joint_design import AxisLoad, JointDesign
    from trundle.mechanism import Payload

HELP = "Find the pushes, or the trajectory of joints, that best discriminate two models."
EXAMPLE = """trundle design slope.toml bias.toml --object recording/ --out design/
trundle design joint_dry_friction:elbow joint_load_friction:elbow --object arm/ --out design/"""

LIMITS = {
    "force": ("N", "maximum force at the grasp, N (default: as recorded, or 30)"),
    "torque": ("NM", "maximum torque at the grasp, N·m (default: as recorded, or 8)"),
    "duration": ("S", "time in contact, or of a trajectory, s (default: as recorded, or 6)"),
    "speed": ("V", "maximum speed of the object, m/s, or of the joints (default: as recorded, or 0.6)"),
    "spin": ("W", "maximum angular velocity of the object, rad/s (default: as recorded, or 1)"),
    "distance": ("M", "maximum displacement of the object, m (default: as recorded, or 1.2)"),
}
"""Limits of a push: option, metavar, help."""
JOINT_LIMITS = {
    "acceleration": ("A", "maximum acceleration of the joints (default: as recorded)"),
    "effort": ("U", "maximum effort of the joints, N·m or N (default: as recorded)"),
}
"""Limits of a trajectory of joints: option, metavar, help."""
ALTERNATIVES = 4
"""Trajectories that the terminal lists."""
EFFECTS_WITHOUT_PLACE = ("nominal", "base_tilt")
"""Names of explanations that contain no colon."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the two models, the recording, the noise, the limits, the loads and the output folder."""
    text = (
        "first model.toml; fitted if there is a recording, otherwise it must contain all values; for joints "
        "also names of effects joined by +, such as joint_dry_friction:elbow, or nominal"
    )
    parser.add_argument("model_a", metavar="MODEL_A", type=parse_model, help=text)
    parser.add_argument("model_b", metavar="MODEL_B", type=parse_model, help="second model, in the same form")
    for name in ("model_a", "model_b"):
        declare(parser, name, Input(name.upper(), "file", "a model file (model.toml)"))
    parser.add_argument(
        "--object",
        metavar="PATH",
        type=Path,
        help="recording of the object or of the joints, to which both models are fitted, or a file with the "
        "[body] of the object (default: the body of MODEL_A)",
    )
    declare(parser, "object", Input("--object", "any"))
    add_mjcf(
        parser,
        "joints: MJCF or URDF file that replaces the recording's model; --object may then be a CSV log",
    )
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
    for name, (metavar, help) in {**LIMITS, **JOINT_LIMITS}.items():
        parser.add_argument(f"--{name}", metavar=metavar, type=float, default=None, help=help)
    parser.add_argument(
        "--payload",
        metavar="BODY=KG",
        action="append",
        default=[],
        type=parse_payload,
        help="joints of a model: known mass at the origin of a body, to compare as load; may be repeated",
    )
    parser.add_argument(
        "--axis-load",
        metavar=("TORQUE", "INERTIA"),
        type=float,
        nargs=2,
        action="append",
        default=[],
        help="one axis: known load to compare, N·m at sin q = 1 and kg·m²; may be repeated",
    )
    add_out(
        parser,
        "folder for design.json and, if the models can be simulated, scenario.toml and object.toml; for "
        "joints trajectory.csv",
        Output("--out", "folder"),
    )
    parser.add_argument("--json", action="store_true", help="print the design as JSON")
    add_quiet(parser)


def parse_model(text: str) -> Path | str:
    """Return the path of a model file, or names of effects."""
    is_name = ":" in text or text in EFFECTS_WITHOUT_PLACE
    return text if is_name and not Path(text).exists() else Path(text)


def parse_payload(text: str) -> tuple[str, float]:
    """Return the body and the mass of BODY=KG."""
    body, sign, mass = text.rpartition("=")
    try:
        if body and sign:
            return body, float(mass)
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"{text!r}: write BODY=KG, such as forearm=0.5")


def run(args: argparse.Namespace) -> int:
    """Design the experiment, print it and write the files."""
    from trundle.design import DEFAULT_NOISE_SD, Design
    from trundle.experiment_design import design

    recorded = args.object is not None and (args.object.is_dir() or args.mjcf is not None)
    options: dict[str, Any] = {name: getattr(args, name) for name in {**LIMITS, **JOINT_LIMITS}}
    options["recording" if recorded else "object"] = args.object
    with Progress(f"designing for {args.model_a} and {args.model_b}", quiet=args.quiet) as progress:
        found: Design | JointDesign = design(
            args.model_a,
            args.model_b,
            mjcf=args.mjcf,
            noise=DEFAULT_NOISE_SD if args.noise is None else tuple(args.noise),
            pushes=args.pushes,
            loads=_loads(args),
            progress=progress.share,
            **options,
        )
    for warning in found.warnings:
        print(f"trundle: warning: {warning}", file=sys.stderr)
    rows = format_design(found) if isinstance(found, Design) else format_joint_design(found)
    print(found.to_json() if args.json else "\n".join(rows))
    if args.out is not None:
        found.write(args.out)
    return 0


def _loads(args: argparse.Namespace) -> tuple[AxisLoad | Payload, ...]:
    """Return the loads that the design may add."""
    if not (args.payload or args.axis_load):
        return ()
    from trundle.joint_design import AxisLoad
    from trundle.mechanism import Payload

    payloads = [Payload(body, mass) for body, mass in args.payload]
    return (*payloads, *(AxisLoad(torque, inertia) for torque, inertia in args.axis_load))


def format_joint_design(found: JointDesign) -> list[str]:
    """Format a design for joints for the terminal."""
    rows = [found.sentence, _recorded(found)]
    for number, one in enumerate(found.trajectories[1:ALTERNATIVES], 2):
        first, second = one.separation
        rows.append(f"  {number}. {one.sentence} {first:.3g} or {second:.3g} nats")
    return [row for row in rows if row]


def format_design(found: Design) -> list[str]:
    """Format a design for the terminal."""
    rows = [row for row in (found.sentence, _recorded(found)) if row]
    if len(found.pushes) > 1:
        rows += [
            f"  push {k + 1}: {push.separation:.3g} nats, {push.cumulative:.3g} nats with the previous pushes"
            for k, push in enumerate(found.pushes)
        ]
    return rows


def _recorded(found: Design | JointDesign) -> str:
    """Return which model the recording prefers, or an empty text without one."""
    if abs(found.recorded) >= 0.5:
        first, second = found.models if found.recorded > 0 else found.models[::-1]
        return f"  so far the recording prefers {first} to {second} by {abs(found.recorded):.1f} nats"
    return "  so far the recording prefers neither" if found.recorded else ""
