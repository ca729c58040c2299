"""Model cards of dynamics models (Mitchell et al. 2019)."""

from __future__ import annotations

from collections.abc import Sequence

from trundle.experiments.markdown import prose, table
from trundle.experiments.results import Row
from trundle.experiments.training.config import Dynamics
from trundle.experiments.training.dynamics.errors import OPEN_LOOP_S
from trundle.experiments.training.dynamics.model import DynamicsModel

__all__ = ["error_table", "model_card"]


def error_table(errors: Sequence[Row]) -> str:
    """Return the table of prediction errors after several durations of observed motion."""
    head = ["observed motion", "episodes", "speed", "spin", "distance", "turn"]
    lines = [
        [
            f"{row['history']:g} s",
            f"{row['episodes']:.0f}",
            f"{100 * row['speed']:.1f} cm/s",
            f"{row['spin']:.3f} rad/s",
            f"{100 * row['distance']:.1f} cm",
            f"{row['turn']:.3f} rad",
        ]
        for row in errors
    ]
    return table(head, lines)


def model_card(settings: Dynamics, model: DynamicsModel, errors: Sequence[Row], torch: str) -> str:
    """Return the card of a dynamics model as Markdown.

    Parameters
    ----------
    settings : Dynamics
    model : DynamicsModel
    errors : sequence of dict
        Errors of the ensemble in the worlds of evaluations; see `prediction_errors`.
    torch : str
        PyTorch's version.
    """
    about = model.about
    memory = f"a memory (LSTM, {settings.units} units)" if settings.units else "no memory: it does not adapt"
    data = f"{settings.random_share:.0%} random, the others towards the goal"
    facts = [
        ("environment", f"`{about.env}` with `{about.env_kwargs}`"),
        ("networks", f"{len(model.networks)} with {memory}"),
        ("input", "twist, wrenches at the start and the end of a step, bounding box, in axes of the object"),
        ("output", f"twist and displacement after {about.period:g} s"),
        ("parameters", f"{model.parameters:,}"),
        ("data", f"{about.steps:,} steps of {about.period:g} s; pushes: {data}"),
        ("updates of each network", f"{about.updates:,}"),
        ("settings", f"`{about.config}.toml`, seed {about.seed}, digest `{about.digest}`"),
        ("PyTorch", torch),
    ]
    tables = {"table": table(["property", "value"], facts), "errors": error_table(errors)}
    return prose("training", "dynamics", about=about, open_loop=OPEN_LOOP_S, **tables) + "\n"
