"""The report of a diagnosis: one HTML file without scripts or external resources.

The figures are SVG that `markup` and `figures` write. Matplotlib is not used, for these reasons:

- Panels are 360 units wide and CSS arranges them, so text has the same size on a phone and on a desktop.
- Lines and text take their colours from the style sheet, so dark mode and print need no second figure.
- Text stays text: it is searchable and accessible. Each figure has a title and a description.
- The same input gives the same bytes: no dates, no hashed ids, no plotting library version.
- A recording of 25,000 samples takes about ten kilobytes per panel (see `decimate`).
"""

from trundle.report.inputs import inputs
from trundle.report.page import render

__all__ = ["inputs", "render"]
