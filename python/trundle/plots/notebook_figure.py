"""A matplotlib figure that notebooks display without pyplot."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

__all__ = ["NotebookFigure"]

_DPI = 200
"""Resolution in a notebook, dots per inch: twice that of the page, for displays of high resolution."""


class NotebookFigure(Figure):
    """A figure that IPython displays as PNG.

    IPython knows plain figures only after pyplot has been imported.
    """

    def _repr_png_(self) -> tuple[bytes, dict[str, int]]:
        """Return the PNG and its width and height on the page, CSS pixels."""
        drawn = io.BytesIO()
        self.savefig(drawn, format="png", dpi=_DPI)
        width, height = self.get_size_inches()
        return drawn.getvalue(), {"width": round(0.5 * _DPI * width), "height": round(0.5 * _DPI * height)}
