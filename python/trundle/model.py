"""Models: a rigid body plus a list of effects, and the catalogue of effects.

Examples
--------
>>> import trundle
>>> [effect["kind"] for effect in trundle.effects()][:2]
['viscous_wheel', 'coulomb_friction']
"""

from trundle._native import Model, effects

__all__ = ["Model", "effects"]
