"""The report in a real browser: no requests, no overflow, legible, and no meaning by colour alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.browser import scripts
from tests.browser.chromium import Browser

PHONE, DESK = 390, 1280
QUIET = ("Network.requestWillBeSent", "Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded")


@pytest.mark.parametrize("width", [PHONE, DESK])
def test_no_overflow_overlap_or_network_request(browser: Browser, page: Path, width: int) -> None:
    browser.open(page, width)
    browser.evaluate(scripts.UNFOLD)
    assert browser.evaluate(scripts.COLLISIONS) == []
    assert browser.evaluate(scripts.OUTSIDE) == []
    assert browser.evaluate(scripts.SCROLLED) == []
    assert browser.evaluate("document.documentElement.scrollWidth <= document.documentElement.clientWidth")
    assert requests(browser) == [page.as_uri()]


def test_every_effect_fits_a_phone_screen(browser: Browser, effect: Path) -> None:
    browser.open(effect, PHONE)
    browser.evaluate(scripts.UNFOLD)
    assert browser.evaluate(scripts.COLLISIONS) == []
    assert browser.evaluate(scripts.OUTSIDE) == []
    assert browser.evaluate(scripts.SCROLLED) == []
    assert requests(browser) == [effect.as_uri()]


def requests(browser: Browser) -> list[str | None]:
    """Return the requests of the page; None for each console message."""
    noisy = [event for event in browser.events if event.get("method") in QUIET]
    return [event["params"].get("request", {}).get("url") for event in noisy]


def test_requests_and_console_messages_are_detected(browser: Browser, tmp_path: Path) -> None:
    bad = tmp_path / "bad.html"
    image = '<img src="http://127.0.0.1:9/x.png" class="long" style="display:block;width:2000px">'
    bad.write_text(f"<!doctype html><script>console.log(1)</script>{image}", encoding="utf-8")
    browser.open(bad, DESK)
    assert browser.evaluate(scripts.OUTSIDE) == ["IMG.long"]
    found = requests(browser)
    assert "http://127.0.0.1:9/x.png" in found and None in found


def test_text_in_figures_is_legible_on_a_phone(browser: Browser, page: Path) -> None:
    browser.open(page, PHONE)
    assert browser.evaluate(scripts.SMALLEST) >= 10.0


def test_every_link_has_a_target(browser: Browser, page: Path) -> None:
    browser.open(page, DESK)
    assert browser.evaluate("document.querySelectorAll('nav a').length") >= 3
    assert browser.evaluate(scripts.DEAD_LINKS) == []


def test_every_figure_has_a_name_and_a_description(browser: Browser, page: Path) -> None:
    browser.open(page, DESK)
    nodes = browser.call("Accessibility.getFullAXTree")["nodes"]
    images = [node for node in nodes if node["role"]["value"] in ("image", "img") and not node["ignored"]]
    texts = [node.get("name", {}).get("value", "") for node in images]
    assert len(texts) == browser.evaluate("document.querySelectorAll('figure:not(details figure)').length")
    assert all(len(text) > 30 for text in texts), texts
    headings = [node["name"]["value"] for node in nodes if node["role"]["value"] == "heading"]
    assert all(headings)


@pytest.mark.parametrize(("medium", "scheme"), [("", "light"), ("", "dark"), ("print", "light")])
def test_colours_contrast_with_the_background(
    browser: Browser, table: Path, medium: str, scheme: str
) -> None:
    browser.emulate(medium, scheme)
    browser.open(table, DESK)
    colours = browser.evaluate(scripts.COLOURS)
    browser.emulate()
    for name, least in (("ink", 7.0), ("muted", 4.5), ("after", 4.5), ("mark", 4.5), ("before", 3.0)):
        assert contrast(colours[name], colours["paper"]) >= least, name
    assert contrast(colours["recorded"], colours["paper"]) >= 3.0
    assert contrast(colours["ink"], colours["soft"]) >= 7.0


def contrast(first: str, second: str) -> float:
    """Return the contrast ratio of WCAG 2, 1 to 21."""
    low, high = sorted((luminance(first), luminance(second)))
    return (high + 0.05) / (low + 0.05)


def luminance(colour: str) -> float:
    """Return the relative luminance of #rgb or #rrggbb (WCAG 2)."""
    digits = colour.lstrip("#")
    wide = digits if len(digits) == 6 else "".join(2 * digit for digit in digits)
    shares = [int(wide[start : start + 2], 16) / 255.0 for start in (0, 2, 4)]
    linear = [share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4 for share in shares]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_contrast_follows_wcag() -> None:
    assert contrast("#fff", "#000000") == pytest.approx(21.0)
    assert contrast("#777777", "#fff") == pytest.approx(4.48, abs=0.01)


def test_lines_differ_by_more_than_colour(browser: Browser, table: Path) -> None:
    browser.open(table, DESK)
    dashes = browser.evaluate(scripts.DASHES)
    assert len({tuple(style) for style in dashes.values()}) == 3
    assert dashes["before"][0] != "none" and dashes["after"][0] == "none"
