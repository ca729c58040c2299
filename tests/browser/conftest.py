"""A browser for the session, and the reports as files; skipped without a browser."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.browser.chromium import Browser, find
from tests.report.effects import EFFECTS, effect_sample
from tests.report.samples import SAMPLES
from trundle.report import render


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """A headless Chromium."""
    path = find()
    if path is None:
        pytest.skip("no browser: put chromium or google-chrome on PATH, or name one in TRUNDLE_BROWSER")
    with Browser(path) as found:
        yield found


@pytest.fixture(scope="session", params=sorted(SAMPLES))
def page(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of each sample."""
    path: Path = tmp_path_factory.mktemp(request.param) / "report.html"
    path.write_text(render(*SAMPLES[request.param]()), encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of one sample."""
    path: Path = tmp_path_factory.mktemp("table") / "report.html"
    path.write_text(render(*SAMPLES["table"]()), encoding="utf-8")
    return path


@pytest.fixture(scope="session", params=sorted(EFFECTS))
def effect(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report for each effect."""
    path: Path = tmp_path_factory.mktemp(request.param) / "report.html"
    path.write_text(render(*effect_sample(request.param)), encoding="utf-8")
    return path
