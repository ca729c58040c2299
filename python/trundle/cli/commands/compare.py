"""`trundle compare`: agents on the same hidden worlds."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from trundle.cli.options import add_backend, add_quiet, positive_int, select_backend

HELP = "Let agents play the same hidden worlds, and write down who does how well."
EXAMPLE = "trundle compare configs/experiments/compare_small.toml --jobs 2 --out comparison"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the comparison's file, its size, and where things lie."""
    parser.add_argument("config", metavar="CONFIG", type=Path, help="which agents play which worlds")
    parser.add_argument(
        "--worlds",
        metavar="N",
        type=positive_int,
        help="only the first N of each group (default: as in CONFIG)",
    )
    add_backend(parser)
    parser.add_argument(
        "--work",
        metavar="DIR",
        type=Path,
        help="episodes as they end; an interrupted comparison goes on from them (default: in the system's "
        "temporary directory)",
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        default=Path("docs"),
        help="folder of the document, its results and images/ (default docs)",
    )
    parser.add_argument("--fresh", action="store_true", help="forget the episodes that were played")
    parser.add_argument(
        "--redraw", action="store_true", help="no episode: the document from the results that are there"
    )
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Compare, and print the document."""
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
