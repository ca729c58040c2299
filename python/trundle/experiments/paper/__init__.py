"""The experiments of Scholz et al., section V, and two further ones.

An experiment is a module with the members of `Experiment`: its settings, its trials, how to run one, and the
values and figure of its section of `docs/paper.md`. `trundle paper NAME` runs it.
"""

from __future__ import annotations

from trundle.experiments.paper import fig5, fig6, fig8, open_loop, wheel_position
from trundle.experiments.paper.experiment import Experiment

__all__ = ["EXPERIMENTS", "Experiment"]

EXPERIMENTS: dict[str, Experiment] = {
    "fig5": fig5,
    "fig6": fig6,
    "fig8": fig8,
    "open-loop": open_loop,
    "wheel": wheel_position,
}
"""By the name on the command line, in the order of the document."""
