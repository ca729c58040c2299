"""A comparison that takes a second: short episodes, few samples, five worlds."""

from __future__ import annotations

from pathlib import Path

TINY = """
format = "trundle-compare/1"
name = "tiny"
title = "A tiny comparison"
main = "adaptive"
pairs = [["adaptive", "fixed"]]
targets = [{ worlds = "table", agent = "adaptive", figure = "regret", most = 9.0 }]

[worlds.table]
title = "A table"
env = "trundle/PushAround-v0"
options = { hidden = "locked", horizon = 12 }
first = 70
count = 3
agents = ["oracle", "adaptive", "fixed"]

[worlds.rubbing]
title = "Any object that rubs"
env = "trundle/PushPose-v0"
options = { object = "random", horizon = 12 }
first = 5
count = 2
agents = ["fixed", "oracle"]
effect = [{ kind = "coulomb_friction", at = "foot", force = [10.0, 30.0] }]

[agents.oracle]
title = "Oracle"
kind = "oracle"
settings = { planner = { samples = 8 } }

[agents.adaptive]
title = "Adaptive"
kind = "adaptive"
settings = { planner = { samples = 8 }, starts = 1 }

[agents.fixed]
title = "Fixed"
kind = "adaptive"
settings = { planner = { samples = 8 }, adapt = false }
"""


def written(folder: Path, text: str = TINY) -> Path:
    """Write the file of a comparison."""
    path = folder / "tiny.toml"
    path.write_text(text)
    return path
