"""Closed-loop runs: an agent pushes an object to its goal and learns a model of it.

`config` reads the settings, `episode` runs an episode, `folder` stores the results, `history` reads them,
`sentences` and `page` report them.
"""

from trundle.experiments.runs.run import run_closed_loop

__all__ = ["run_closed_loop"]
