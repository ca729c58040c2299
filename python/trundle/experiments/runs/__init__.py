"""Closed-loop runs: an agent pushes an object to its goal and learns a model of it (`trundle run`)."""

from trundle.experiments.runs.run import run_closed_loop

__all__ = ["run_closed_loop"]
