"""The experiments of Scholz et al., section V, and two that the paper left open, as commands.

An experiment is one module with what `Experiment` names: its trials, how one is done, and the section of
`docs/paper.md` that is written from their results. `trundle paper NAME` runs it.
"""

from __future__ import annotations

from trundle.experiments.paper import fig5, fig6, fig8, open_loop, wheel_position
from trundle.experiments.paper.experiment import Experiment, Options

__all__ = ["EXPERIMENTS", "Experiment", "Options"]

EXPERIMENTS: dict[str, Experiment] = {
    "fig5": fig5,
    "fig6": fig6,
    "fig8": fig8,
    "open-loop": open_loop,
    "wheel": wheel_position,
}
"""By the name on the command line, in the order of the document."""
