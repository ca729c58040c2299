"""`trundle export`: convert a model for MuJoCo, or a recording to MCAP."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from trundle.cli.options import add_out
from trundle.cli.paths import Input, Output, declare
from trundle.progress import Progress

HELP = "Export a diagnosed or fitted model to MuJoCo, or a recording to MCAP for Foxglove and rosbag2."
EXAMPLE = """trundle export diagnosis/table/model.toml --mujoco --out table_mujoco
  trundle export recordings/table --mcap table.mcap"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the source, the format, the footprint and the output folder."""
    parser.add_argument(
        "source",
        metavar="SOURCE",
        type=Path,
        help="model.toml with a value for every parameter; with --mcap a recording",
    )
    declare(parser, "source", Input("SOURCE", "any"))
    kinds = parser.add_mutually_exclusive_group()
    kinds.add_argument(
        "--mujoco", action="store_true", help="write the model as MJCF with a Python callback (default)"
    )
    kinds.add_argument(
        "--mcap", metavar="FILE", type=Path, help="write the recording as ROS 2 messages in one .mcap file"
    )
    declare(parser, "mcap", Output("--mcap", "file", (".mcap",), content="an export to MCAP"))
    parser.add_argument(
        "--footprint",
        metavar="CORNERS",
        type=parse_corners,
        help="footprint for a model without one: '[[x, y], ...]' in metres, object frame",
    )
    add_out(
        parser,
        "output folder for MuJoCo (default: name of SOURCE with _mujoco appended)",
        Output("--out", "folder", marker="object.xml", content="an export"),
    )


def run(args: argparse.Namespace) -> int:
    """Export the source and print the paths of the files."""
    from trundle.export import to_mujoco, write_mcap

    if args.mcap:
        if args.out or args.footprint:
            raise ValueError(f"--mcap {args.mcap}: --out and --footprint apply only to --mujoco; remove them")
        with Progress("writing") as progress:
            written = write_mcap(args.source, args.mcap, progress.show)
        print(written)
        return 0
    if args.source.is_dir():
        raise ValueError(f"{args.source}: is a folder, not a model file; use --mcap FILE for a recording")
    out = args.out or args.source.with_name(f"{args.source.stem}_mujoco")
    folder = to_mujoco(args.source, out, footprint=args.footprint)
    print("\n".join(str(path) for path in sorted(folder.iterdir())))
    return 0


def parse_corners(text: str) -> list[list[float]]:
    """Parse corners given as JSON."""
    try:
        points = [[float(x), float(y)] for x, y in json.loads(text)]
    except (ValueError, TypeError):
        points = []
    if len(points) < 3:
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of at least three corners '[[x, y], ...]'")
    return points
