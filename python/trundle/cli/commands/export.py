"""`trundle export`: convert a model for MuJoCo, or a recording to MCAP."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from trundle.cli.options import add_mjcf, add_out
from trundle.cli.paths import Input, Output, declare
from trundle.progress import Progress

HELP = "Export a diagnosed or fitted model to MuJoCo, or a recording to MCAP for Foxglove and rosbag2."
EXAMPLE = """trundle export diagnosis/table/model.toml --mujoco --out table_mujoco
  trundle export diagnosis/arm/model.toml --mjcf-patch arm_patched --mjcf robot.xml
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
    kinds.add_argument(
        "--mjcf-patch",
        metavar="OUT",
        type=Path,
        help="write the MJCF of a mechanism with the refitted values and missing effects into a folder",
    )
    declare(
        parser, "mjcf_patch", Output("--mjcf-patch", "folder", marker="robot.xml", content="a patched model")
    )
    add_mjcf(
        parser, "MJCF or URDF file for --mjcf-patch (default: that of [mechanism] model, next to SOURCE)"
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
    from trundle.export import to_mujoco, write_mcap, write_mjcf_patch

    if args.mjcf and not args.mjcf_patch:
        raise ValueError(f"--mjcf {args.mjcf}: applies only to --mjcf-patch; remove it")
    if (args.mcap or args.mjcf_patch) and (args.out or args.footprint):
        kind = f"--mcap {args.mcap}" if args.mcap else f"--mjcf-patch {args.mjcf_patch}"
        raise ValueError(f"{kind}: --out and --footprint apply only to --mujoco; remove them")
    if args.mcap:
        with Progress("writing") as progress:
            written = write_mcap(args.source, args.mcap, progress.show)
        print(written)
        return 0
    if args.source.is_dir():
        raise ValueError(f"{args.source}: is a folder, not a model file; use --mcap FILE for a recording")
    if args.mjcf_patch:
        print_files(write_mjcf_patch(args.source, args.mjcf_patch, mjcf=args.mjcf))
        return 0
    out = args.out or args.source.with_name(f"{args.source.stem}_mujoco")
    print_files(to_mujoco(args.source, out, footprint=args.footprint))
    return 0


def print_files(folder: Path) -> None:
    """Print the paths of the files in a folder."""
    print("\n".join(str(path) for path in sorted(folder.iterdir())))


def parse_corners(text: str) -> list[list[float]]:
    """Parse corners given as JSON."""
    try:
        points = [[float(x), float(y)] for x, y in json.loads(text)]
    except (ValueError, TypeError):
        points = []
    if len(points) < 3:
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of at least three corners '[[x, y], ...]'")
    return points
