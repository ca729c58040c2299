"""`trundle compare`: compare agents on the same hidden worlds."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from trundle.cli.options import add_backend, add_quiet, positive_int, select_backend

HELP = "Compare agents on the same hidden worlds and write the results as a document."
EXAMPLE = "trundle compare configs/experiments/compare_small.toml --jobs 2 --out comparison"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the configuration, the number of worlds and the folders."""
    parser.add_argument(
        "config", metavar="CONFIG", type=Path, help="settings: which agents play in which worlds"
    )
    parser.add_argument(
        "--worlds",
        metavar="N",
        type=positive_int,
        help="use only the first N worlds of each group (default: as in CONFIG)",
    )
    add_backend(parser)
    parser.add_argument(
        "--work",
        metavar="DIR",
        type=Path,
        help="folder of finished episodes, from which an interrupted comparison continues (default: in the "
        "temporary directory of the system)",
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        default=Path("docs"),
        help="folder for the document, its results and images/ (default docs)",
    )
    parser.add_argument("--fresh", action="store_true", help="discard finished episodes")
    parser.add_argument(
        "--redraw", action="store_true", help="write the document from existing results, without new episodes"
    )
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Run the comparison and print the document."""
    from trundle.experiments.comparison.run import compare

    text = compare(
        args.config,
        args.work or Path(tempfile.gettempdir()) / "trundle-compare",
        args.out,
        count=args.worlds,
        backend=select_backend(args),
        fresh=args.fresh,
        redraw=args.redraw,
        quiet=args.quiet,
    )
    print(text)
    return 0
