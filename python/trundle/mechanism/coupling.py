"""Joints that follow recorded joints: mimic joints, and joints tied by an equality constraint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

__all__ = ["Coordinates", "Coupling"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Coupling:
    """A joint that follows another one: displacement = polynomial(displacement of the driver).

    Displacements are relative to the model's reference `qpos0`.
    """

    driver: str
    polynomial: Polynomial


class Coordinates:
    """The joints of a compiled model as functions of the recorded joints.

    Parameters
    ----------
    names : sequence of str
        All joints of the model, in its order.
    reference : (N,) array
        Their reference positions.
    recorded : sequence of str
        The recorded joints, in the order of the recording.
    couplings : mapping of str to Coupling
        Of every other joint.
    """

    def __init__(
        self,
        names: tuple[str, ...],
        reference: Floats,
        recorded: tuple[str, ...],
        couplings: Mapping[str, Coupling],
    ) -> None:
        self.reference = reference
        self.n = len(recorded)
        self.source = np.zeros(len(names), dtype=np.intp)
        """(N,) The recorded joint that each joint of the model follows."""
        self.index = np.array([names.index(name) for name in recorded], dtype=np.intp)
        """(n,) The position of each recorded joint among the model's."""
        self.polynomials: list[Polynomial] = []
        identity = Polynomial([0.0, 1.0])
        for k, name in enumerate(names):
            polynomial = identity
            while name not in recorded:
                polynomial = polynomial(couplings[name].polynomial)
                name = couplings[name].driver
            self.source[k] = recorded.index(name)
            self.polynomials.append(polynomial)

    def expand(self, q: Floats, v: Floats, a: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return positions, velocities, accelerations of all joints, and their slopes by the recorded ones.

        Parameters
        ----------
        q, v, a : (T, n) arrays
            Motion of the recorded joints.

        Returns
        -------
        q, v, a, slope : (T, N) arrays
        """
        x = q[:, self.source] - self.reference[self.index][self.source]
        v, a = v[:, self.source], a[:, self.source]
        value, slope, curvature = (np.empty_like(x) for _ in range(3))
        for k, polynomial in enumerate(self.polynomials):
            value[:, k] = polynomial(x[:, k])
            slope[:, k] = polynomial.deriv()(x[:, k])
            curvature[:, k] = polynomial.deriv(2)(x[:, k])
        return value + self.reference, slope * v, slope * a + curvature * v**2, slope

    def project(self, effort: Floats, slope: Floats) -> Floats:
        """Return the efforts at recorded joints that do the same work as efforts at all joints.

        Parameters
        ----------
        effort : (T, N, ...) array
        slope : (T, N) array

        Returns
        -------
        (T, n, ...) array
        """
        work = effort * slope.reshape(slope.shape + (1,) * (effort.ndim - 2))
        out = np.zeros((effort.shape[0], self.n, *effort.shape[2:]))
        for k, source in enumerate(self.source):
            out[:, source] += work[:, k]
        return out
