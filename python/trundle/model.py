"""Models: a rigid body plus a list of effects, and the catalogues of effects.

Examples
--------
>>> import trundle
>>> [effect["kind"] for effect in trundle.effects()][:2]
['viscous_wheel', 'coulomb_friction']
"""

from typing import Any

from trundle._native import Model, _joint_effects, effects

__all__ = ["Model", "effects", "joint_effects"]


def joint_effects() -> list[dict[str, Any]]:
    """Return the catalogue of effects of mechanisms.

    Returns
    -------
    list of dict
        Each with ``kind`` and ``effect`` (the same name), ``summary``, ``source``, ``parameters`` (name and
        unit for a hinge) and ``experiment``: the motion that separates it from other effects.

    Examples
    --------
    >>> [effect["effect"] for effect in trundle.joint_effects()][:1]
    ['joint_dry_friction']
    """
    return [{"kind": effect["effect"], **effect} for effect in _joint_effects()]
