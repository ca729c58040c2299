"""`trundle export`: a model for another simulator, a recording for robot tools."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from trundle.cli.options import add_out
from trundle.cli.progress import Progress

HELP = "Write a diagnosed or fitted model for another simulator, or a recording for Foxglove and rosbag2."
EXAMPLE = """trundle export diagnosis/table/model.toml --mujoco --out table_mujoco
  trundle export recordings/table --mcap table.mcap"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the model or recording, what it becomes, the footprint and where to write."""
    parser.add_argument(
        "source",
        metavar="SOURCE",
        type=Path,
        help="model.toml with a value for every parameter; for --mcap a recording",
    )
    kinds = parser.add_mutually_exclusive_group()
    kinds.add_argument("--mujoco", action="store_true", help="as MJCF and a Python callback (the default)")
    kinds.add_argument("--mcap", metavar="FILE", type=Path, help="as ROS 2 messages in one .mcap file")
    parser.add_argument(
        "--footprint",
        metavar="CORNERS",
        type=parse_corners,
        help="shape of an object whose model names none: '[[x, y], ...]', metres, object frame",
    )
    add_out(parser, "folder to write for MuJoCo (default SOURCE's name with _mujoco)")


def run(args: argparse.Namespace) -> int:
    """Export and say what was written."""
    from trundle.export import to_mujoco, write_mcap

    if args.mcap:
        if args.out or args.footprint:
            raise ValueError(f"--mcap {args.mcap} says where to write; --out and --footprint are for MuJoCo")
        with Progress("writing") as progress:
            written = write_mcap(args.source, args.mcap, progress.show)
        print(written)
        return 0
    if args.source.is_dir():
        raise ValueError(f"{args.source}: a folder is no model; a recording is exported with --mcap FILE")
    out = args.out or args.source.with_name(f"{args.source.stem}_mujoco")
    folder = to_mujoco(args.source, out, footprint=args.footprint)
    print("\n".join(str(path) for path in sorted(folder.iterdir())))
    return 0


def parse_corners(text: str) -> list[list[float]]:
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
