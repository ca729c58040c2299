"""The page of a comparison in a real browser."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.browser import scripts
from tests.browser.chromium import Browser
from tests.browser.test_report import DESK, PHONE, requests
from tests.experiments.comparison.test_tables import RESULTS, SETTINGS
from trundle.experiments.comparison import page
from trundle.experiments.comparison.document import render_page


@pytest.fixture(scope="module")
def comparison(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of a comparison of three worlds."""
    text = render_page(
        SETTINGS, RESULTS, {}, "| agent | mean, ms |\n| --- | --- |\n| Mine | 3 |", Path("c.toml")
    )
    path = tmp_path_factory.mktemp("comparison") / "n.html"
    path.write_text(page.render(text, SETTINGS, RESULTS, {}), encoding="utf-8")
    return path


@pytest.mark.parametrize(("width", "scheme"), [(PHONE, "dark"), (DESK, "light"), (DESK, "dark")])
def test_it_fits_and_is_legible(browser: Browser, comparison: Path, width: int, scheme: str) -> None:
    browser.emulate("", scheme)
    browser.open(comparison, width)
    faint = browser.evaluate(scripts.FAINT)
    browser.emulate()
    assert faint == []
    assert browser.evaluate(scripts.COLLISIONS) == []
    assert browser.evaluate(scripts.OUTSIDE) == []
    assert browser.evaluate("document.documentElement.scrollWidth <= document.documentElement.clientWidth")
    assert browser.evaluate(scripts.SMALLEST) >= 10.0
    assert requests(browser) == [comparison.as_uri()]


def test_outcomes_are_sorted_by_success(browser: Browser, comparison: Path) -> None:
    browser.open(comparison, DESK)
    outcomes = "[...document.querySelectorAll('table')].find(one => one.textContent.includes('collision'))"
    agents = f"[...{outcomes}.tBodies[0].rows].map(row => row.cells[0].textContent)"
    assert browser.evaluate(agents) == ["Oracle", "Mine"]
    browser.evaluate(f"{outcomes}.querySelectorAll('.sort')[1].click()")
    assert browser.evaluate(agents) == ["Mine", "Oracle"], "the lower success first"
