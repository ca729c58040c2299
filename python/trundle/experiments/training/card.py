"""Model cards of trained policies (Mitchell et al. 2019)."""

from __future__ import annotations

from trundle.experiments.markdown import prose, table
from trundle.experiments.results import Row
from trundle.experiments.training.policy import About
from trundle.experiments.training.settings import Settings

__all__ = ["model_card"]


def model_card(settings: Settings, about: About, result: Row, torch: str) -> str:
    """Return the card of a policy as Markdown.

    Parameters
    ----------
    settings : Settings
    about : About
        Metadata of the policy.
    result : dict
        The result of the training, with its curve.
    torch : str
        PyTorch's version and device.
    """
    last = result["curve"][-1]
    worlds = settings.evaluation
    rates = {key: f"{100 * last[key]:.1f} %" for key in ("success", "untouched", "lost")}
    sees = "the observations of the environment"
    sees = f"the last {about.frame_stack} observations" if about.frame_stack > 1 else sees
    sees += f" with {about.hidden} hidden parameters" if about.hidden else ""
    facts = [
        ("algorithm", about.algorithm),
        ("environment", f"`{about.env}` with `{about.env_kwargs}`"),
        ("input", f"{sees}, in the frame of the {about.frame}"),
        ("output", f"the mean action, {'as a hyperbolic tangent' if about.squashed else 'clipped'}"),
        ("parameters", f"{result['parameters']:,}"),
        ("steps, simulated time", f"{about.steps:,}, {result['simulated_seconds'] / 3600:.0f} h"),
        ("reward shaping", f"`{settings.aids}`" if settings.algorithm != "RMA" else "none"),
        ("converged", "yes" if result["flattened"] else "no: the curve still improved at the end"),
        ("settings", f"`{about.config}.toml`, seed {about.seed}, digest `{about.digest}`"),
        ("PyTorch", torch),
    ]
    text = prose(
        "training", "policy", about=about, worlds=worlds, table=table(["property", "value"], facts), **rates
    )
    return text + "\n"
