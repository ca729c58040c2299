"""`trundle predict`: simulate a recording's episodes in open loop."""

from __future__ import annotations

import argparse

from trundle.cli.options import add_model, add_out, add_recording

HELP = "Simulate every episode of a recording in open loop, beside what was recorded."
EXAMPLE = "trundle predict recording/ --model model.toml --out predictions.parquet"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the recording, the model and the table to write."""
    add_recording(parser)
    add_model(parser, required=True)
    add_out(parser, "Parquet table to write", required=True)


def run(args: argparse.Namespace) -> int:
    """Predict and say where."""
    import trundle

    print(trundle.predict(args.recording, args.model, args.out))
    return 0
