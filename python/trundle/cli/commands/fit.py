"""`trundle fit`: estimate a model's parameters from a recording."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from trundle.cli.options import add_model, add_out, add_prior, add_quiet, add_recording, add_seed
from trundle.cli.paths import Output
from trundle.progress import Progress

HELP = "Estimate a model's parameters from a recording's training episodes."
EXAMPLE = "trundle fit recording/ --out model.toml"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the recordings, the model, the priors, the likelihood, the search and the output file."""
    add_recording(parser, several=True)
    add_model(parser)
    add_prior(parser)
    add_likelihood(parser)
    add_out(parser, "output model.toml, with the fitted values and the posterior", Output("--out", "file"))
    parser.add_argument(
        "--starts", metavar="N", type=int, default=6, help="number of random starts (default 6)"
    )
    parser.add_argument(
        "--optimiser",
        choices=["lm", "lbfgs"],
        default="lm",
        help="lm: Levenberg–Marquardt (default); lbfgs: L-BFGS, as in the paper",
    )
    parser.add_argument(
        "--profile",
        metavar="NAME",
        help="print the profile likelihood of one parameter instead, such as body.mass",
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    add_seed(parser)
    add_quiet(parser)


def add_likelihood(parser: argparse.ArgumentParser) -> None:
    """Add the options of the likelihood."""
    parser.add_argument(
        "--likelihood",
        choices=["filter", "steps", "final", "windows", "wrench"],
        help="filter: one-step prediction errors of poses (default); steps: displacements (eq. 8); final: "
        "final poses (eq. 9); windows: poses over windows (default if the object can reach a known "
        "obstacle); wrench: the required wrench",
    )
    parser.add_argument(
        "--window", metavar="S", type=float, default=1.0, help="length of a window, s (default 1.0)"
    )
    parser.add_argument(
        "--loss",
        choices=["gaussian", "student"],
        default="gaussian",
        help="distribution of the residuals (default gaussian)",
    )
    parser.add_argument(
        "--per-episode",
        metavar="NAME",
        action="append",
        default=[],
        help="estimate this parameter separately for each episode, such as body.mass; may be repeated",
    )
    parser.add_argument("--no-obstacles", action="store_true", help="ignore the obstacles of the recording")


def run(args: argparse.Namespace) -> int:
    """Fit the model, print the result and write the model."""
    import trundle

    if args.profile is not None:
        return run_profile(args)
    warn_about_held_out(args.recording)
    with Progress(f"fitting {', '.join(map(str, args.recording))}", quiet=args.quiet) as progress:
        fitted = trundle.fit(
            args.recording,
            args.model,
            likelihood=args.likelihood,
            window=args.window,
            loss=args.loss,
            per_episode=args.per_episode,
            obstacles=False if args.no_obstacles else None,
            prior=args.prior,
            starts=args.starts,
            seed=args.seed,
            optimiser=args.optimiser,
            progress=progress.share,
        )
    if args.out is not None:
        fitted.model.write(args.out)
    print(
        json.dumps(fitted.summary, indent=2, ensure_ascii=False) if args.json else format_fit(fitted.summary)
    )
    return 0


def warn_about_held_out(recordings: Sequence[Path]) -> None:
    """Print a warning for each recording without held-out episodes."""
    from trundle.input_checks import held_out_findings

    for recording in recordings:
        for finding in held_out_findings(recording):
            print(f"trundle: warning: {recording}: {finding}", file=sys.stderr)


def run_profile(args: argparse.Namespace) -> int:
    """Print the profile likelihood of one parameter."""
    import trundle

    if len(args.recording) != 1:
        raise ValueError(f"--profile: needs exactly one recording, not {len(args.recording)}")
    if args.likelihood is not None or args.loss != "gaussian" or args.per_episode:
        raise ValueError(
            "--profile: supports only the default likelihood; remove --likelihood, --loss and --per-episode"
        )
    with Progress(f"profiling {args.profile}", quiet=args.quiet) as progress:
        profile = trundle.profile(
            args.recording[0],
            args.profile,
            args.model,
            prior=args.prior,
            starts=args.starts,
            seed=args.seed,
            progress=progress.share,
        )
    fields = {**vars(profile), "values": profile.values.tolist(), "deviance": profile.deviance.tolist()}
    print(json.dumps(fields, indent=2, ensure_ascii=False) if args.json else profile.plot())
    return 0


UNITS = {
    "position_rmse": "m",
    "heading_rmse": "rad",
    "final_position_error": "m",
    "final_heading_error": "rad",
    "r2": "(dimensionless)",
    "window_position_rmse": "m",
    "window_heading_rmse": "rad",
    "force_bandwidth": "Hz",
    "force_rmse": "N",
    "torque_rmse": "N·m",
    "log_predictive_density": "nats per pose sample",
}
"""Units of the metrics in `training` and `held_out`."""


def format_fit(summary: Mapping[str, Any]) -> str:
    """Format the estimates and the error metrics for the terminal."""
    from trundle.identifiability import format_identifiability

    rows = [f"{summary['recording']}: {lack_of_fit_line(summary['lack_of_fit'])}"]
    rows += [f"  {line}" for line in model_error_lines(summary)]
    if not summary["converged"]:
        rows.append("  NOT CONVERGED: try more --starts")
    if summary["quasi_static"]:
        rows.append("  quasi-static: compared by the wrench; these data do not determine the mass")
    rows += [f"  {sentence}" for sentence in summary["excluded_by_prior"]]
    rows += [f"  {parameter['name']:32}{format_estimate(parameter)}" for parameter in summary["parameters"]]
    if "identifiability" in summary:
        rows += [f"  {line}" for line in format_identifiability(summary["identifiability"])]
    for part in ("training", "held_out"):
        rows += [
            f"  {part} {key}: {value:.5g} {UNITS[key]}"
            for key, value in (summary[part] or {}).items()
            if value is not None
        ]
    return "\n".join(rows)


def lack_of_fit_line(lack: dict[str, Any] | None) -> str:
    """Return a phrase on the result of the lack-of-fit test."""
    if lack is None:
        return "lack of fit not tested (only the default likelihood of motion has a test)"
    if lack["found"]:
        return "the model does not explain these data: run `trundle diagnose`"
    return "the model explains these data (no lack of fit found)"


def model_error_lines(summary: Mapping[str, Any]) -> list[str]:
    """Return the lines on the size of the lack of fit and on the model error in the intervals."""
    lack, intervals = summary["lack_of_fit"], summary["intervals"]
    if lack is None or not lack["found"]:
        return []
    rows = [
        f"residual force {lack['residual_force_rms']:.3g} N rms, "
        f"torque {lack['residual_torque_rms']:.3g} N·m rms"
    ]
    if intervals["basis"] == "sandwich":
        rows.append(
            f"standard deviations and 90 % intervals include the model error, estimated from "
            f"{intervals['episodes']} episodes"
        )
    else:
        rows.append("intervals DO NOT include the model error, which needs at least three training episodes")
    return rows


def format_estimate(parameter: dict[str, Any]) -> str:
    """Format an estimate with its standard deviation, unit and 90 % interval."""
    if not parameter["identifiable"]:
        return "not identifiable from these data"
    unit, low, high = parameter["unit"], parameter["low"], parameter["high"]
    value = f"{parameter['mean']:12.5g} ± {parameter['sd']:.2g} {unit}"
    return f"{value:36}  90 %: {low:.5g} to {high:.5g} {unit}"
