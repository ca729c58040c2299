"""The report of a diagnosis: one HTML file, which needs no network and works without scripts.

`page` collects plain data, `templates` holds the HTML, and `figures` draws SVG. Matplotlib is not used for
the figures, for these reasons:

- Panels are 360 units wide and CSS arranges them, so text has the same size on a phone and on a desktop.
- Lines and text take their colours from the style sheet, so dark mode and print need no second figure.
- Text stays text: it is searchable and accessible. Each figure has a title and a description.
- The same input gives the same bytes: no dates, no hashed ids, no plotting library version.
- The link below each figure contains its data, from which one script shows values and zooms.
- A recording of 25,000 samples takes about ten kilobytes per panel (see `decimate`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from trundle.report.inputs import inputs

__all__ = ["inputs", "render"]


def __dir__() -> list[str]:
    return __all__


def render(diagnosis: Mapping[str, Any], series: Mapping[str, Any]) -> str:
    """Render the whole report, see `trundle.report.page.render`.

    Jinja and the figures are imported on the first call, so that `import trundle` does not wait for them.

    Examples
    --------
    >>> page = trundle.report.render(diagnosis.answer, diagnosis.series)
    >>> "</html>" in page
    True
    """
    from trundle.report import page

    return page.render(diagnosis, series)
