"""`trundle export`: a model for another simulator."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from trundle.cli.options import add_out

HELP = "Write a diagnosed or fitted model for another simulator."
EXAMPLE = "trundle export diagnosis/table/model.toml --mujoco --out table_mujoco"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the model, the simulator, the footprint and where to write."""
    parser.add_argument(
        "model", metavar="MODEL", type=Path, help="model.toml with a value for every parameter"
    )
    parser.add_argument("--mujoco", action="store_true", help="as MJCF and a Python callback (the default)")
    parser.add_argument(
        "--footprint",
        metavar="CORNERS",
        type=corners,
        help="shape of an object whose model names none: '[[x, y], ...]', metres, object frame",
    )
    add_out(parser, "folder to write (default MODEL's name with _mujoco)")


def run(args: argparse.Namespace) -> int:
    """Export and say what was written."""
    from trundle.export import to_mujoco

    out = args.out or args.model.with_name(f"{args.model.stem}_mujoco")
    folder = to_mujoco(args.model, out, footprint=args.footprint)
    print("\n".join(str(path) for path in sorted(folder.iterdir())))
    return 0


def corners(text: str) -> list[list[float]]:
    """Return corners given as JSON."""
    try:
        points = [[float(x), float(y)] for x, y in json.loads(text)]
    except (ValueError, TypeError):
        points = []
    if len(points) < 3:
        raise argparse.ArgumentTypeError(
            f"at least three corners as '[[x, y], ...]' are needed, not {text!r}"
        )
    return points
