"""Contacts of a mechanism along a motion."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from trundle.mechanism.motion import check_motion
from trundle.mechanism.source import import_mujoco

if TYPE_CHECKING:
    from trundle.mechanism.model import Mechanism

__all__ = ["touching_bodies"]


def touching_bodies(mechanism: Mechanism, q: ArrayLike) -> dict[tuple[str, str], float]:
    """Return the pairs of bodies that touch along a motion, with the share of the samples in which they do.

    Convex hulls of neighbouring links often overlap. MuJoCo then pushes the links apart with large forces,
    which are part of the inverse dynamics. If the real links do not touch, exclude the pair in the model or
    load it with ``contacts=False``.

    Parameters
    ----------
    mechanism : Mechanism
    q : (T, n) array_like
        Positions of the recorded joints.

    Examples
    --------
    >>> from trundle.mechanism import Mechanism, touching_bodies
    >>> text = '''<mujoco><worldbody><body name="base"><geom size="0.1"/>
    ...   <body name="arm"><joint name="elbow"/><geom size="0.1"/></body></body></worldbody></mujoco>'''
    >>> touching_bodies(Mechanism.load(text, ["elbow"]), [[0.0], [0.1]])
    {('base', 'arm'): 1.0}
    """
    mujoco, model, data = import_mujoco(), mechanism.compiled, mechanism.data
    positions, _, _ = check_motion(mechanism.joints, q, np.zeros_like(q), np.zeros_like(q))
    full = mechanism.coordinates.expand(positions, 0 * positions, 0 * positions)[0]
    counts: Counter[tuple[str, str]] = Counter()
    for row in full:
        data.qpos[:] = row
        mujoco.mj_fwdPosition(model, data)
        found = model.geom_bodyid[data.contact.geom[: data.ncon]]
        counts.update({(model.body(first).name, model.body(second).name) for first, second in found})
    return {pair: count / len(full) for pair, count in counts.items()}
