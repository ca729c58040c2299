"""`trundle predict`: open-loop simulation of the episodes of a recording."""

from __future__ import annotations

import argparse

from trundle.cli.options import add_model, add_out, add_recording

HELP = "Simulate every episode of a recording in open loop, and write predicted and recorded poses."
EXAMPLE = "trundle predict recording/ --model model.toml --out predictions.parquet"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the recording, the model and the output file."""
    add_recording(parser)
    add_model(parser, required=True)
    add_out(parser, "output Parquet file", required=True)


def run(args: argparse.Namespace) -> int:
    """Write the predictions and print the path of the file."""
    import trundle

    trundle.predict(args.recording, args.model, args.out)
    print(args.out)
    return 0
