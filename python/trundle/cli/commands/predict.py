"""`trundle predict`: open-loop simulation of the episodes of a recording."""

from __future__ import annotations

import argparse

from trundle.cli.options import add_model, add_out, add_recording
from trundle.cli.paths import Output

HELP = "Simulate every episode of a recording in open loop, and write predicted and recorded poses."
EXAMPLE = "trundle predict recording/ --model model.toml --out predictions.parquet"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the recording, the model and the output file."""
    add_recording(parser)
    add_model(parser, required=True)
    output = Output("--out", "file", (".parquet",), content="a prediction")
    add_out(parser, "output Parquet file", output, required=True)


def run(args: argparse.Namespace) -> int:
    """Write the predictions and print the path of the file."""
    import trundle

    parameters = trundle.Model.read(args.model).parameters
    free = [parameter["name"] for parameter in parameters if parameter["value"] is None]
    if free:
        raise ValueError(
            f"--model = {args.model}: no value for {', '.join(free)}; fit them first: "
            f"`trundle fit {args.recording} --model {args.model} --out fitted.toml`"
        )
    trundle.predict(args.recording, args.model, args.out)
    print(args.out)
    return 0
