"""Closed-loop runs: an agent pushes an object to its goal and learns what is hidden.

`config` reads what is to be run, `episode` plays, `folder` keeps, `told` reads what was kept and puts it into
words, `page` draws it.
"""

from trundle.experiments.runs.run import run_closed_loop

__all__ = ["run_closed_loop"]
