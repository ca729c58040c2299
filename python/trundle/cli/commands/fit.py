"""`trundle fit`: estimate a model's parameters from a recording."""

from __future__ import annotations

import argparse
import json
from typing import Any

from trundle.cli.options import add_model, add_out, add_prior, add_quiet, add_recording, add_seed
from trundle.cli.progress import Progress

HELP = "Estimate a model's parameters from a recording's training episodes."
EXAMPLE = "trundle fit recording/ --out model.toml"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the recording, the model, the priors, the starts and where to write."""
    add_recording(parser)
    add_model(parser)
    add_prior(parser)
    add_out(parser, "model.toml to write, with every value filled in and the posterior")
    parser.add_argument("--starts", metavar="N", type=int, default=6, help="random starts (default 6)")
    parser.add_argument("--json", action="store_true", help="print the result for programs")
    add_seed(parser)
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Fit, print, and write the model."""
    import trundle

    with Progress(f"fitting {args.recording}", quiet=args.quiet) as progress:
        fitted = trundle.fit(
            args.recording,
            args.model,
            prior=args.prior,
            starts=args.starts,
            seed=args.seed,
            progress=lambda what, done: progress.show(f"{what} {done:.0%}"),
        )
    if args.out is not None:
        fitted.model.write(args.out)
    print(json.dumps(fitted.summary, indent=2, ensure_ascii=False) if args.json else table(fitted.summary))
    return 0


def table(summary: dict[str, Any]) -> str:
    """Return the estimates and figures for a terminal."""
    rows = [f"{summary['recording']}"]
    if not summary["converged"]:
        rows.append("  NOT CONVERGED: try more --starts")
    if summary["quasi_static"]:
        rows.append("  quasi-static: judged by the wrench; the mass is not in these data")
    rows += [f"  {sentence}" for sentence in summary["excluded_by_prior"]]
    for parameter in summary["parameters"]:
        value = "not identifiable from these data"
        if parameter["identifiable"]:
            value = f"{parameter['mean']:12.5g} ± {parameter['sd']:.2g} {parameter['unit']}"
        rows.append(f"  {parameter['name']:32}{value}")
    for part in ("training", "held_out"):
        rows += [
            f"  {part} {key}: {value:.5g}"
            for key, value in (summary[part] or {}).items()
            if value is not None
        ]
    return "\n".join(rows)
