"""The templates escape values, reject undefined ones, and are files of the package."""

from __future__ import annotations

from importlib import resources

import jinja2
import pytest

from tests.report.answers import Sample
from trundle.report import render
from trundle.report.jinja import render_template


def test_values_are_escaped_and_control_characters_replaced(samples: dict[str, Sample]) -> None:
    diagnosis, series = samples["table"]
    page = render(diagnosis | {"recording": "<b>\x00&"}, series)
    assert page.count("&lt;b&gt;\N{REPLACEMENT CHARACTER}&amp;") == 2  # the title and the first line


def test_an_undefined_value_is_an_error() -> None:
    with pytest.raises(jinja2.UndefinedError, match="title"):
        render_template("trundle.report", "report.html")


def test_the_style_sheets_are_included_unchanged(samples: dict[str, Sample]) -> None:
    folder = resources.files("trundle.report").joinpath("templates")
    styles = [file for file in folder.iterdir() if file.name.endswith(".css")]
    page = render(*samples["table"])
    assert len(styles) == 5
    assert all(file.read_text(encoding="utf-8").rstrip() in page for file in styles)
