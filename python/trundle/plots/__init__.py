"""Figures of recordings, fits, residuals, posteriors and diagnoses, with matplotlib (extra ``[plots]``).

Each function returns a `matplotlib.figure.Figure`, which a notebook displays; none uses pyplot. With
``figure=`` they draw on an existing figure or subfigure.
"""

from trundle.plots.corner import posterior
from trundle.plots.fits import fit
from trundle.plots.residuals import residual
from trundle.plots.streams import recording
from trundle.plots.verdict import diagnosis

__all__ = ["diagnosis", "fit", "posterior", "recording", "residual"]
