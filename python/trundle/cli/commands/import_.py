"""`trundle import`: convert data of other formats to a recording."""

from __future__ import annotations

import argparse
from pathlib import Path

from trundle.cli.options import add_quiet
from trundle.cli.progress import Progress
from trundle.importers import IMPORTERS

HELP = "Convert a ROS 2 bag, CSV or MATLAB files, or a published data set to a recording."
EXAMPLE = "trundle import run_3.mcap --from mcap --map bag.toml --out recordings/run_3"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the source, its layout, its map and the output folder."""
    parser.add_argument("source", metavar="SOURCE", type=Path, help="file or folder to import")
    parser.add_argument(
        "--from",
        dest="layout",
        metavar="LAYOUT",
        choices=sorted(IMPORTERS),
        help=f"{', '.join(sorted(IMPORTERS))} (default: the suffix of a .csv, .mat or .mcap file)",
    )
    parser.add_argument(
        "--map",
        metavar="MAP",
        type=Path,
        help="TOML file that assigns topics, columns or variables to the columns of a recording",
    )
    parser.add_argument("--out", metavar="DIR", type=Path, required=True, help="folder of the new recording")
    parser.add_argument(
        "--table", choices=["csv", "parquet"], default="csv", help="format of the tables (default csv)"
    )
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Read the source, validate and write the recording, and print what was omitted."""
    from trundle import Recording, TrundleError
    from trundle.importers import SourceError, read

    layout = args.layout or args.source.suffix.removeprefix(".")
    if layout not in IMPORTERS:
        raise SourceError(
            args.source, f"unknown layout; give --from with one of {', '.join(sorted(IMPORTERS))}"
        )
    with Progress("reading", quiet=args.quiet) as progress:
        imported = read(args.source, layout, args.map, progress.show)
        progress.show("writing")
        try:
            recording = Recording(imported.metadata, imported.episodes)
        except TrundleError as error:
            hint = "; add missing values to [recording] in the map" if args.map else ""
            raise ValueError(f"{args.source}: not a valid recording: {error}{hint}") from error
        recording.write(args.out, table=args.table)
    rows = sum(len(table["t"]) for table in imported.episodes.values())
    episodes = len(imported.episodes)
    print(f"{args.out}: {episodes} episode{'s' * (episodes != 1)}, {rows} rows")
    if not args.quiet:
        for remark in imported.remarks:
            print(f"  {remark}")
    return 0
