"""`trundle import`: convert data of other formats to a recording."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from trundle.cli.options import add_quiet
from trundle.cli.paths import RECORDING, Input, Output, declare
from trundle.cli.settings_pairs import add_set
from trundle.importers import IMPORTERS
from trundle.progress import Progress

HELP = "Convert a ROS 2 bag, CSV, MATLAB or LeRobot files, or a published data set to a recording."
EXAMPLE = """trundle import log.csv --guess --out recordings/run_3
  trundle import run_3.mcap --from mcap --map bag.toml --out recordings/run_3
  trundle import so101/ --from so101 --set joint=Pitch --out recordings/pitch"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the source, its layout, its map and the output folder."""
    parser.add_argument("source", metavar="SOURCE", type=Path, help="file or folder to import")
    declare(parser, "source", Input("SOURCE", "any"))
    parser.add_argument(
        "--from",
        dest="layout",
        metavar="LAYOUT",
        choices=sorted(IMPORTERS),
        help=f"{', '.join(sorted(IMPORTERS))} (default: the suffix of a .csv, .mat or .mcap file)",
    )
    maps = parser.add_mutually_exclusive_group()
    maps.add_argument(
        "--map",
        metavar="MAP",
        type=Path,
        help="TOML file that assigns topics, columns or variables to the columns of a recording",
    )
    maps.add_argument(
        "--guess",
        action="store_true",
        help="for CSV: propose a map from the names of the columns, and ask for missing keys",
    )
    maps.add_argument(
        "--init", metavar="MAP", type=Path, help="for CSV: write the proposed map, with comments, and stop"
    )
    add_set(parser, "without --map: a key of the map, such as recording.wrench.sign=on_object or format=2")
    parser.add_argument("--out", metavar="DIR", type=Path, help="folder of the new recording")
    declare(parser, "map", Input("--map", "file", "a map file (docs/import.md)"))
    declare(parser, "init", Output("--init", "file", content="a map"))
    declare(parser, "out", RECORDING)
    parser.add_argument(
        "--table", choices=["csv", "parquet"], default="csv", help="format of the tables (default csv)"
    )
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Read the source, validate and write the recording, and print what was omitted."""
    layout = select_layout(args)
    if args.init is not None:
        return write_init(args)
    if args.out is None:
        raise ValueError(f"{args.source}: --out DIR is missing: the folder of the new recording")
    write_recording(args, layout, guessed_map(args) if args.guess else args.map or given_map(args))
    return 0


def select_layout(args: argparse.Namespace) -> str:
    """Return the layout of the source, and check that the options apply to it."""
    from trundle.importers import SourceError

    guesses = args.guess or args.init is not None
    suffix = args.source.suffix.lower().removeprefix(".")
    layout = str(args.layout or ("csv" if guesses and args.source.is_dir() else suffix))
    if layout not in IMPORTERS:
        raise SourceError(
            args.source, f"unknown layout; give --from with one of {', '.join(sorted(IMPORTERS))}"
        )
    if guesses and layout != "csv":
        raise SourceError(args.source, f"--guess and --init read CSV files, not {layout}; give --map")
    if args.set and args.map is not None:
        raise ValueError("--set: applies only without --map; write the keys into the map")
    return layout


def write_init(args: argparse.Namespace) -> int:
    """Write the proposed map and print its missing keys."""
    from trundle.cli.guessing import guess, list_questions
    from trundle.importers import write_map

    if args.init.exists():
        raise ValueError(f"--init {args.init}: exists; remove it, or give another name")
    found = guess(args.source, args.set, ask=False)
    print(f"{write_map(found, args.init)}: {list_questions(found) if found.questions else 'complete'}")
    print(
        f"complete the file, then run `trundle import {args.source} --from csv --map {args.init} --out DIR`"
    )
    return 0


def given_map(args: argparse.Namespace) -> Mapping[str, Any] | None:
    """Return the map that --set gives, if any."""
    from trundle.cli.guessing import nested

    return nested(args.set) or None


def guessed_map(args: argparse.Namespace) -> Mapping[str, Any]:
    """Print the proposed map and return it; raise `ValueError` if keys are missing."""
    from trundle.cli.guessing import guess, list_questions
    from trundle.importers import map_text

    found = guess(args.source, args.set, ask=True)
    if found.questions or not args.quiet:
        print(map_text(found), flush=True)
    if found.questions:
        raise ValueError(
            f"{args.source}: {list_questions(found)}\nor write the map with --init MAP, and edit it"
        )
    return found.settings


def write_recording(
    args: argparse.Namespace, layout: str, source_map: Path | Mapping[str, Any] | None
) -> None:
    """Import the source with a map, and print what was written and omitted."""
    from trundle import TrundleError
    from trundle.importers import read

    with Progress("reading", quiet=args.quiet) as progress:
        imported = read(args.source, layout, source_map, progress.show)
        progress.show("writing")
        try:
            recording = imported.recording()
        except TrundleError as error:
            hint = "; add missing values to [recording] in the map" if source_map else ""
            raise ValueError(f"{args.source}: not a valid recording: {error}{hint}") from error
        recording.write(args.out, table=args.table)
    rows = sum(len(table["t"]) for table in imported.episodes.values())
    episodes = len(imported.episodes)
    print(f"{args.out}: {episodes} episode{'s' * (episodes != 1)}, {rows} rows")
    if not args.quiet:
        for remark in imported.remarks:
            print(f"  {remark}")
        print(f"  next: `trundle check {args.out}` tests units, signs, axes and clocks")
