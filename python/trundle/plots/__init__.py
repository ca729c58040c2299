"""Figures of recordings, fits, residuals, posteriors and diagnoses, with matplotlib (extra ``[plots]``).

Each function returns a `matplotlib.figure.Figure`, which a notebook displays; none uses pyplot. With
``figure=`` they draw on an existing figure or subfigure. The functions are imported on first use, so that
`import trundle` does not wait for them.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from trundle.plots.corner import posterior
    from trundle.plots.fits import fit
    from trundle.plots.residuals import residual
    from trundle.plots.streams import recording
    from trundle.plots.verdict import diagnosis

__all__ = ["diagnosis", "fit", "posterior", "recording", "residual"]

_MODULES = {
    "diagnosis": "verdict",
    "fit": "fits",
    "posterior": "corner",
    "recording": "streams",
    "residual": "residuals",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
