"""The diagnosis for people: one HTML file that is understood in a minute.

The figures are drawn by a small SVG layer of our own (`markup`, `figures`) and not by matplotlib:

- a phone is 390 px wide: panels are laid out 360 units wide and flow by CSS, so that text is as large
  there as on a desk; matplotlib fixes the page at drawing time;
- lines and text take their colours from the page's style sheet, so dark mode and print are the same figure;
- text stays text (searchable, read aloud, any font), each figure has a title and a description;
- the bytes depend on the input alone: no dates, no hashed ids, no version of a plotting library;
- a recording of 25,000 samples becomes some ten kilobytes a panel (see `decimate`).
"""

from trundle.report.inputs import inputs
from trundle.report.page import render

__all__ = ["inputs", "render"]
