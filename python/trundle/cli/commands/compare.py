"""`trundle compare`: compare agents on the same hidden worlds."""

from __future__ import annotations

import argparse
from pathlib import Path

from trundle._optional import require
from trundle.cli.options import add_config, add_execution, positive_int, select_execution

HELP = "Compare agents on the same hidden worlds and write the results as a document and a page."
EXAMPLE = "trundle compare configs/experiments/compare_small.toml --jobs 2 --out comparison"

DEFAULT_OUT = "comparison"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the configuration, the number of worlds and the folders."""
    add_config(parser, "settings: which agents play in which worlds")
    parser.add_argument(
        "--worlds",
        metavar="N",
        type=positive_int,
        help="use only the first N worlds of each group (default: as in CONFIG)",
    )
    add_execution(parser, "episodes", "the document, its results and images/", DEFAULT_OUT)


def run(args: argparse.Namespace) -> int:
    """Run the comparison and print the document."""
    for module in ("matplotlib", "scipy"):
        require(module, "experiments", "comparisons")
    from trundle.experiments.comparison.run import compare

    print(compare(args.config, select_execution(args, "compare", Path(DEFAULT_OUT)), args.worlds))
    return 0
