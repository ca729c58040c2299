"""The page of a run in a real browser: no requests, no overflow, legible, and with a working slider."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.browser import scripts
from tests.browser.chromium import Browser
from tests.browser.test_report import DESK, PHONE, requests
from tests.experiments.runs.samples import SAMPLES, episode
from trundle.experiments.runs.config import Settings
from trundle.experiments.runs.page import render

SHOWN_TEXT = "document.querySelector('.player output').textContent"
PLACED = "document.querySelector('.player .moving').getAttribute('transform')"
SLIDE = """(() => {
  const slider = document.querySelector('.player input');
  slider.value = 20;
  slider.dispatchEvent(new Event('input'));
})()"""


@pytest.fixture(scope="module", params=sorted(SAMPLES))
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of each sample."""
    return written(tmp_path_factory.mktemp(request.param), request.param)


def written(folder: Path, name: str) -> Path:
    """Write the page of a sample."""
    settings = Settings(
        "trundle/PushAround-v0", arguments={"hidden": "locked"}, text='format = "trundle-run/1"'
    )
    page = folder / "page.html"
    page.write_text(
        render(settings, "run.toml", [episode(**given) for given in SAMPLES[name]]), encoding="utf-8"
    )
    return page


@pytest.mark.parametrize("width", [PHONE, DESK])
def test_no_overflow_overlap_or_network_request(browser: Browser, run: Path, width: int) -> None:
    browser.open(run, width)
    browser.evaluate(scripts.UNFOLD)
    assert browser.evaluate(scripts.COLLISIONS) == []
    assert browser.evaluate(scripts.OUTSIDE) == []
    assert browser.evaluate(scripts.SCROLLED) == []
    assert browser.evaluate("document.documentElement.scrollWidth <= document.documentElement.clientWidth")
    assert browser.evaluate(scripts.SMALLEST) >= 10.0
    assert browser.evaluate(scripts.DEAD_LINKS) == []
    assert browser.evaluate("new Set([...document.querySelectorAll('[id]')].map(e => e.id)).size") == (
        browser.evaluate("document.querySelectorAll('[id]').length")
    )
    assert requests(browser) == [run.as_uri()]


def test_the_slider_moves_the_object_and_the_belief(browser: Browser, tmp_path: Path) -> None:
    browser.open(written(tmp_path, "friction"), DESK)
    end, text = browser.evaluate(PLACED), browser.evaluate(SHOWN_TEXT)
    assert text.startswith("3.50")
    browser.evaluate(SLIDE)
    assert browser.evaluate(PLACED) != end
    assert browser.evaluate(SHOWN_TEXT).startswith("1.00")
    assert browser.evaluate("document.querySelectorAll('.player .estimate-marks ellipse').length") == 1
    assert requests(browser) == [browser.evaluate("location.href")]


def test_the_button_plays_and_pauses(browser: Browser, tmp_path: Path) -> None:
    browser.open(written(tmp_path, "found"), DESK)
    press = "document.querySelector('.player button').click()"
    label = "document.querySelector('.player button').textContent"
    browser.evaluate(press)
    assert browser.evaluate(label) == "Pause"
    assert float(browser.evaluate("document.querySelector('.player input').value")) < 60
    browser.evaluate(press)
    assert browser.evaluate(label) == "Play"


def test_it_prints_without_controls(browser: Browser, tmp_path: Path) -> None:
    browser.emulate("print")
    browser.open(written(tmp_path, "found"), 794)
    hidden = browser.evaluate("getComputedStyle(document.querySelector('.controls')).display")
    browser.emulate()
    assert hidden == "none"
