"""Export of models to other simulators and of recordings to robot tools.

- `to_mujoco` writes a folder that MuJoCo loads with this package installed.
- `Laws` evaluates the forces of a model for any simulator.
- `draw` samples the parameters of a model from its posterior.
- `write_mjcf_patch` writes a patched MJCF of a mechanism.
- `write_mcap` writes a recording for Foxglove and rosbag2.
"""

from __future__ import annotations

from trundle._native import Laws, Model, TrundleError
from trundle.export.folder import to_mujoco
from trundle.export.mcap import write_mcap
from trundle.export.mjcf_patch import write_mjcf_patch
from trundle.export.randomise import draw, ranges

__all__ = ["Laws", "Model", "TrundleError", "draw", "ranges", "to_mujoco", "write_mcap", "write_mjcf_patch"]


def __dir__() -> list[str]:
    return __all__
