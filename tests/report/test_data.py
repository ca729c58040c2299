"""The data of figures: links that need no network, and rows that keep every peak."""

from __future__ import annotations

import csv
import io
import re
from html import unescape
from urllib.parse import unquote

import numpy as np
import pytest

from tests.report.answers import Sample
from trundle.report import render
from trundle.report.decimate import representative_rows
from trundle.report.figures.curves import Curve, Lane, table
from trundle.report.figures.data import MAX_ROWS, Data


def tables(page: str) -> dict[str, list[list[str]]]:
    """Return the rows of each figure's data by the name of its file."""
    links = re.findall(r'<a class="data" href="data:text/csv;charset=utf-8,([^"]*)" download="([^"]*)"', page)
    return {name: list(csv.reader(io.StringIO(unquote(unescape(text))))) for text, name in links}


def test_every_figure_has_its_data(page: str) -> None:
    found = tables(page)
    assert len(found) == page.count("<figure>") > 0
    for name, (head, *rows) in found.items():
        assert head and {len(row) for row in rows} == {len(head)}, name


def test_the_data_are_the_drawn_curves(samples: dict[str, Sample]) -> None:
    diagnosis, series = samples["table"]
    head, *rows = tables(render(diagnosis, series))["motion-0.csv"]
    episode = next(each for each in series["episodes"] if each["held_out"])
    times = [float(row[0]) for row in rows]
    assert len(rows) <= MAX_ROWS and times[0] == episode["t"][0] and times[-1] == episode["t"][-1]
    column = head.index("recorded x, m")
    expected = np.interp(times, episode["t"], np.array(episode["observed"])[:, 0])
    assert [float(row[column]) for row in rows] == pytest.approx(expected.tolist(), rel=1e-4, abs=1e-6)


def test_peaks_of_every_column_are_kept() -> None:
    t = np.linspace(0.0, 10.0, 20_000)
    values = np.column_stack([np.sin(t), np.cos(t), np.zeros(len(t))])
    values[1234, 2], values[17_000, 0], values[5000:5100, 1] = 9.0, -7.0, np.nan
    rows = representative_rows(t, values, 300)
    assert len(rows) <= 300 and (np.diff(rows) > 0).all()
    assert values[rows, 2].max() == 9.0 and values[rows, 0].min() == -7.0
    assert np.diff(t[rows]).max() < 0.2, "gaps"


def test_curves_with_other_times_are_interpolated_inside_them() -> None:
    lane = Lane(
        "force, N",
        (
            Curve("a", np.array([0.0, 2.0]), np.array([0.0, 4.0])),
            Curve("b", np.array([1.0, 2.0]), np.array([7.0, 7.0])),
        ),
    )
    found = table([lane])
    assert found.names == ("force, N: a", "force, N: b")
    assert found.t.tolist() == [0.0, 1.0, 2.0]
    assert found.values[:, 0].tolist() == [0.0, 2.0, 4.0]
    assert np.isnan(found.values[0, 1]) and found.values[1:, 1].tolist() == [7.0, 7.0]


def test_text_in_the_data_cannot_leave_the_link() -> None:
    data = Data(('a"><b>', "#?&%"), [("x\ny,", float("nan"))])
    assert not re.search(r'["<>#?&\n]', data.uri)
    head, row = csv.reader(io.StringIO(unquote(data.uri.partition(",")[2])))
    assert (head, row) == (['a"><b>', "#?&%"], ["x\ny,", ""])
