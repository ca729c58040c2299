"""What the script of the page adds: values under the pointer, zoom, sorting, copying; all by keyboard too."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from urllib.parse import unquote

import pytest

from tests.browser import scripts
from tests.browser.chromium import Browser
from tests.browser.test_report import DESK, PHONE, requests

MOTION = "document.querySelector('#motion figure')"
READOUT = f"{MOTION}.querySelector('.readout').textContent"
VIEW = f"{MOTION}.querySelector('.lanes .plot').getAttribute('viewBox').split(' ').map(Number)"
SPOT = f"""(() => {{
  const box = {MOTION}.querySelector('.lanes .plot').getBoundingClientRect();
  return [box.left + 0.6 * box.width, box.top + 0.5 * box.height];
}})()"""
SORT = "document.querySelectorAll('#ranking .sort')"
FIRST_CELLS = "[...document.querySelectorAll('#ranking tbody tr')].map(row => row.cells[0].textContent)"


@pytest.fixture
def motion(browser: Browser, table: Path) -> Browser:
    """The report with its first motion in view."""
    browser.open(table, DESK)
    browser.evaluate(f"{MOTION}.scrollIntoView()")
    return browser


def move(browser: Browser, x: float, y: float) -> None:
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)


def press(browser: Browser, key: str) -> None:
    for kind in ("keyDown", "keyUp"):
        browser.call("Input.dispatchKeyEvent", type=kind, key=key)


def data(browser: Browser) -> list[list[str]]:
    link = browser.evaluate(f"{MOTION}.querySelector('a.data').href")
    return list(csv.reader(io.StringIO(unquote(link.partition(",")[2]))))


def test_the_pointer_shows_the_values_of_the_data(motion: Browser) -> None:
    assert motion.evaluate(READOUT) == ""
    move(motion, *motion.evaluate(SPOT))
    head, *rows = data(motion)
    time = 0.6 * float(rows[-1][0])
    near = min(rows, key=lambda row: abs(float(row[0]) - time))
    texts = motion.evaluate(READOUT).replace("\N{MINUS SIGN}", "-").split()
    assert texts[::2] == ["before", "after"]
    columns = [head.index("position error, m: before"), head.index("position error, m: after")]
    assert [float(text) for text in texts[1::2]] == pytest.approx(
        [float(near[column]) for column in columns], rel=0.01
    )
    assert motion.evaluate(f"{MOTION}.querySelectorAll('line.cursor').length") == 1
    assert motion.evaluate(f"{MOTION}.querySelectorAll('.map circle.here').length") == 3
    move(motion, 1.0, 1.0)
    assert motion.evaluate(READOUT) == ""
    assert motion.evaluate(f"{MOTION}.querySelectorAll('.cursor, .here').length") == 0


def test_buttons_zoom_the_time_axis_and_the_map(motion: Browser) -> None:
    ticks = f"[...{MOTION}.querySelectorAll('.time-axis text')].map(text => text.textContent)"
    bar = f"{MOTION}.querySelector('[data-length]').textContent"
    whole, labels, length = motion.evaluate(VIEW), motion.evaluate(ticks), motion.evaluate(bar)
    motion.evaluate(f"{MOTION}.querySelector('.tools button').click()")
    assert motion.evaluate(VIEW)[2] == pytest.approx(whole[2] / 2)
    assert motion.evaluate(ticks) != labels and motion.evaluate(bar) != length
    assert motion.evaluate(scripts.COLLISIONS) == []
    motion.evaluate(f"[...{MOTION}.querySelectorAll('.tools button')].pop().click()")
    assert motion.evaluate(VIEW) == whole and motion.evaluate(bar) == length


def test_a_figure_works_with_the_keyboard(motion: Browser) -> None:
    whole = motion.evaluate(VIEW)
    motion.evaluate(f"{MOTION}.querySelector('svg').focus()")
    press(motion, "ArrowRight")
    first = motion.evaluate(READOUT)
    press(motion, "ArrowRight")
    assert first and motion.evaluate(READOUT) != first
    assert motion.evaluate("document.querySelector('[aria-live]').textContent") != ""
    press(motion, "+")
    assert motion.evaluate(VIEW)[2] == pytest.approx(whole[2] / 2)
    press(motion, "0")
    assert motion.evaluate(VIEW) == whole


def test_every_control_takes_the_focus_visibly(browser: Browser, table: Path) -> None:
    browser.open(table, DESK)
    expected = browser.evaluate(
        "[...document.querySelectorAll('a, button, summary, pre.copy, figure > svg, .scroll')]"
        ".filter(one => one.checkVisibility() && one.tabIndex >= 0).length"
    )
    seen = set()
    for _ in range(expected):
        browser.call("Input.dispatchKeyEvent", type="keyDown", key="Tab", windowsVirtualKeyCode=9)
        seen.add(
            browser.evaluate(
                "[...document.querySelectorAll('*')].indexOf(document.activeElement)"
                " + ' ' + getComputedStyle(document.activeElement).outlineStyle"
            )
        )
    assert len(seen) == expected > 20
    assert {text.split()[1] for text in seen} == {"solid"}


def test_a_table_is_sorted_by_a_click_and_back(browser: Browser, table: Path) -> None:
    browser.open(table, DESK)
    order = browser.evaluate(FIRST_CELLS)
    browser.evaluate(f"{SORT}[2].click()")
    assert browser.evaluate(FIRST_CELLS) == order[::-1], "from the smallest log evidence on"
    assert browser.evaluate(f"{SORT}[2].closest('th').ariaSort") == "ascending"
    browser.evaluate(f"{SORT}[2].click()")
    assert browser.evaluate(FIRST_CELLS) == order
    browser.evaluate(f"{SORT}[0].click()")
    assert browser.evaluate(FIRST_CELLS) == sorted(order, key=str.lower)
    assert browser.evaluate(f"{SORT}[2].closest('th').ariaSort") is None


def test_the_code_of_the_model_can_be_copied(browser: Browser, table: Path) -> None:
    browser.open(table, DESK)
    browser.evaluate("document.querySelector('.use .copy-button').click()")
    code = browser.evaluate("document.querySelector('.use pre').textContent")
    assert "trundle.Model.read" in code
    assert browser.evaluate("getSelection().toString()").strip() == code.strip()


def test_nothing_is_lost_without_scripts(browser: Browser, page: Path) -> None:
    text = (
        "(() => { const copy = document.querySelector('main').cloneNode(true);"
        " copy.querySelectorAll('.tools span:not(.unseen), .copy-button').forEach(one => one.remove());"
        r" return copy.textContent.replace(/\s+/g, ' '); })()"
    )
    browser.open(page, PHONE)
    scripted = browser.evaluate(text)
    browser.call("Emulation.setScriptExecutionDisabled", value=True)
    try:
        browser.open(page, PHONE)
        assert browser.evaluate("document.querySelectorAll('button').length") == 0
        assert browser.evaluate(text) == scripted
        assert browser.evaluate(scripts.OUTSIDE) == []
    finally:
        browser.call("Emulation.setScriptExecutionDisabled", value=False)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_text_has_the_contrast_of_wcag_aa(browser: Browser, page: Path, scheme: str) -> None:
    browser.emulate("", scheme)
    browser.open(page, DESK)
    browser.evaluate(scripts.UNFOLD)
    faint = browser.evaluate(scripts.FAINT)
    browser.emulate()
    assert faint == []
    assert requests(browser) == [page.as_uri()]


def test_faint_text_is_detected(browser: Browser, tmp_path: Path) -> None:
    bad = tmp_path / "bad.html"
    bad.write_text("<!doctype html><p style='color:#999'>faint</p><p>clear</p>", encoding="utf-8")
    browser.open(bad, DESK)
    assert [text for _, _, text in browser.evaluate(scripts.FAINT)] == ["faint"]
