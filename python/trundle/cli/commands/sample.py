"""`trundle sample`: posterior draws of the parameters of a model."""

from __future__ import annotations

import argparse
import json
from typing import Any

from trundle.cli.options import add_model, add_out, add_prior, add_quiet, add_recording, add_seed
from trundle.cli.paths import Output
from trundle.progress import Progress

HELP = "Sample the posterior of a model's parameters given a recording, with convergence diagnostics."
EXAMPLE = "trundle sample recording/ --out posterior.nc"

METHODS = ("laplace", "nuts", "metropolis")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the recording, the model, the sampler and the output file."""
    add_recording(parser)
    add_model(parser)
    add_prior(parser)
    parser.add_argument(
        "--method",
        choices=METHODS,
        default="laplace",
        help="laplace: normal approximation at the mode (default, seconds); nuts: No-U-Turn sampler "
        "(minutes to hours); metropolis: random walk",
    )
    counts = {
        "chains": (4, "number of chains"),
        "draws": (250, "draws per chain after warm-up"),
        "warmup": (150, "warm-up draws per chain, in which nuts and metropolis adapt their steps"),
        "starts": (6, "number of searches for modes"),
    }
    for name, (default, text) in counts.items():
        text = f"{text} (default {default})"
        parser.add_argument(f"--{name}", metavar="N", type=int, default=default, help=text)
    output = Output("--out", "file", (".nc",), content="a posterior")
    add_out(parser, "output netCDF file, for arviz.from_netcdf", output)
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    add_seed(parser)
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Sample the posterior, print the summary and write the draws."""
    import trundle

    with Progress(f"sampling {args.recording}", quiet=args.quiet) as progress:
        posterior = trundle.sample(
            args.recording,
            args.model,
            method=args.method,
            chains=args.chains,
            draws=args.draws,
            warmup=args.warmup,
            starts=args.starts,
            seed=args.seed,
            prior=args.prior,
            progress=progress.share,
        )
        if args.out is not None:
            progress.show("predicting")
            posterior.write(args.out)
    summary = posterior.summary
    print(json.dumps(summary, indent=2, ensure_ascii=False) if args.json else format_posterior(summary))
    return 0


def format_posterior(summary: dict[str, Any]) -> str:
    """Format a posterior for the terminal."""
    from trundle.cli.commands.fit import lack_of_fit_line

    first = f"{summary['recording']}, {summary['method']}"
    if (summary["lack_of_fit"] or {}).get("found"):
        first += f": {lack_of_fit_line(summary['lack_of_fit'])}"
    rows = [first, f"  {summary['verdict']}"]
    if (summary["lack_of_fit"] or {}).get("found"):
        rows.append(
            "  these draws assume a correct model; the intervals of `trundle fit` include the model error"
        )
    rows += [f"  {sentence}" for sentence in summary["excluded_by_prior"]]
    if len(summary["modes"]) > 1:
        shares = ", ".join(f"{mode['weight']:.1%}" for mode in summary["modes"])
        rows.append(f"  {len(summary['modes'])} modes, shares of the evidence: {shares}")
    if summary["quasi_static"]:
        rows.append("  quasi-static: compared by the wrench; these data do not determine the mass")
    heads = ("mean", "sd", "5 %", "95 %", "R-hat", "ESS bulk", "tail")
    rows.append(f"  {'':32}" + "".join(f"{head:>11}" for head in heads))
    return "\n".join(rows + [format_parameter(parameter) for parameter in summary["parameters"]])


def format_parameter(parameter: dict[str, Any]) -> str:
    """Format a parameter as one line."""
    values = f"{'not identifiable from these data':>44}"
    if parameter["identifiable"]:
        values = "".join(f"{parameter[key]:11.5g}" for key in ("mean", "sd", "low", "high"))
    r_hat = "-" if parameter["r_hat"] is None else f"{parameter['r_hat']:.3f}"
    ess = f"{parameter['ess_bulk']:11.0f}{parameter['ess_tail']:11.0f}"
    return f"  {parameter['name']:32}{values}{r_hat:>11}{ess} {parameter['unit']}"
