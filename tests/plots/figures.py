"""What the tests read from a figure."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

import trundle
from tests.report.answers import Sample


def diagnosis_of(sample: Sample) -> trundle.Diagnosis:
    """Return a diagnosis with the answer and the series of a sample, without a model."""
    answer, series = sample
    return trundle.Diagnosis(cast(Any, answer), cast(Any, None), "", series, cast(Any, None))


def titled(figure: Figure, start: str) -> Axes:
    """Return the axes whose title begins with a text."""
    return next(axes for axes in figure.axes if title(axes).startswith(start))


def title(axes: Axes) -> str:
    return axes.get_title(loc="left") or axes.get_title()


def labels(figure: Figure) -> list[str]:
    """Return titles and labels of all axes."""
    return [
        text for axes in figure.axes for text in (title(axes), axes.get_xlabel(), axes.get_ylabel()) if text
    ]


def lines(axes: Axes) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Yield label and points (n, 2) of each line with data."""
    for line in axes.lines:
        points = np.column_stack([np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)])
        if len(points) > 2:
            yield str(line.get_label()), points


def widths(axes: Axes) -> list[float]:
    """Return the widths of horizontal bars."""
    return [bar.get_width() for bar in axes.patches if isinstance(bar, Rectangle)]


def caption(figure: Figure) -> str:
    return " ".join(str(figure.get_supxlabel()).split())


def legend_texts(figure: Figure) -> set[str]:
    """Return the entries of all legends."""
    own = [axes.get_legend() for axes in figure.axes]
    return {text.get_text() for one in (*figure.legends, *own) if one is not None for text in one.get_texts()}
