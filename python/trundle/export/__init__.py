"""Models for other simulators, recordings for robot tools.

`to_mujoco` writes a folder that MuJoCo loads with nothing but this package beside it; `Laws` is what any
simulator can ask for the forces of a model, `draw` gives it another object that the data allow.
`write_mcap` writes a recording for Foxglove and rosbag2.
"""

from __future__ import annotations

from trundle._native import Laws, Model, TrundleError
from trundle.export.folder import to_mujoco
from trundle.export.mcap import write_mcap
from trundle.export.randomise import draw, ranges

__all__ = ["Laws", "Model", "TrundleError", "draw", "ranges", "to_mujoco", "write_mcap"]
