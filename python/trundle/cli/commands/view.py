"""`trundle view`: a recording, a diagnosis or a run for the Rerun viewer."""

from __future__ import annotations

import argparse
from pathlib import Path

from trundle.cli.options import add_out
from trundle.cli.paths import Input, Output, declare
from trundle.progress import Progress

HELP = "Write a recording, a diagnosis or a run for the Rerun viewer (.rrd); needs the extra `rerun`."
EXAMPLE = "trundle view diagnosis/table --out table.rrd --open"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the source, the recording of a diagnosis, the output file and `--open`."""
    parser.add_argument(
        "source",
        metavar="SOURCE",
        type=Path,
        help="folder of a recording, of a diagnosis (`trundle diagnose`) or of a run (`trundle run`)",
    )
    parser.add_argument(
        "--recording",
        metavar="DIR",
        type=Path,
        help="recording of a diagnosis (default: the one with the stated name near the diagnosis)",
    )
    add_out(
        parser,
        "output file (default: name of SOURCE with .rrd appended)",
        Output("--out", "file", (".rrd",), content="a Rerun recording"),
    )
    declare(parser, "source", Input("SOURCE", "any"))
    declare(parser, "recording", Input("--recording", "recording"))
    parser.add_argument("--open", action="store_true", help="open the file in the Rerun viewer")


def run(args: argparse.Namespace) -> int:
    """Write the file, print its path, and open it if requested."""
    from trundle.viewing import view
    from trundle.viewing.viewer import open_viewer, require_display

    if args.open:
        require_display()
    with Progress(f"reading {args.source}"):
        written = view(args.source, args.out, recording=args.recording)
    print(written)
    if args.open:
        open_viewer(written)
    return 0
