"""The page in a real browser: on a desk, on a phone, on paper."""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.report.browser import Browser, find
from trundle.report import render

PHONE, DESK = 390, 1280
QUIET = ("Network.requestWillBeSent", "Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded")

COLLISIONS = """(() => {
  document.querySelectorAll('details').forEach(each => each.open = true);
  const found = [];
  for (const svg of document.querySelectorAll('figure>svg')) {
    const frame = svg.getBoundingClientRect();
    const title = svg.querySelector('title').textContent;
    const texts = [...svg.querySelectorAll('text')];
    const boxes = texts.map(text => [text.textContent, text.getBoundingClientRect()]);
    boxes.forEach(([name, box], index) => {
      const outside = box.left < frame.left - 1 || box.right > frame.right + 1;
      if (outside || box.bottom > frame.bottom + 1 || box.top < frame.top - 1)
        found.push(title + ': clipped ' + name);
      for (const [other, that] of boxes.slice(index + 1)) {
        const wide = Math.min(box.right, that.right) - Math.max(box.left, that.left);
        const high = Math.min(box.bottom, that.bottom) - Math.max(box.top, that.top);
        if (wide > 1 && high > 3) found.push(title + ': ' + name + ' over ' + other);
      }
    });
  }
  return found;
})()"""

SMALLEST = """Math.min(...[...document.querySelectorAll('figure>svg text')].map(text =>
  parseFloat(getComputedStyle(text).fontSize) * text.ownerSVGElement.getScreenCTM().a))"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    path = find()
    if path is None:
        pytest.skip("no chromium or chrome on PATH")
    with Browser(path) as found:
        yield found


@pytest.fixture()
def page(sample: tuple[dict[str, Any], dict[str, Any]], tmp_path: Path) -> Path:
    path = tmp_path / "report.html"
    path.write_text(render(*sample), encoding="utf-8")
    return path


@pytest.mark.parametrize("width", [PHONE, DESK])
def test_nothing_sticks_out_overlaps_or_calls_home(browser: Browser, page: Path, width: int) -> None:
    browser.open(page, width)
    assert browser.evaluate(COLLISIONS) == []
    assert browser.evaluate("document.documentElement.scrollWidth") <= width
    noisy = [event for event in browser.events if event.get("method") in QUIET]
    requests = [event["params"].get("request", {}).get("url") for event in noisy]
    assert requests == [page.as_uri()], noisy


def test_text_in_figures_is_legible_on_a_phone(browser: Browser, page: Path) -> None:
    browser.open(page, PHONE)
    assert browser.evaluate(SMALLEST) >= 10.0


def test_it_prints_on_a4(browser: Browser, page: Path) -> None:
    browser.open(page, DESK)
    sheets = [tuple(map(float, box)) for box in boxes(browser.pdf())]
    assert 1 < len(sheets) < 16
    assert all(size == pytest.approx((595, 842), abs=2) for size in sheets)


def boxes(pdf: bytes) -> list[tuple[bytes, bytes]]:
    """Width and height in points of each page, from plain and compressed objects."""
    streams = re.findall(rb"stream\r?\n(.*?)endstream", pdf, re.DOTALL)
    inflated = [zlib.decompressobj().decompress(stream) for stream in streams if stream[:1] == b"\x78"]
    pattern = rb"/MediaBox\s*\[\s*0\s+0\s+([\d.]+)\s+([\d.]+)"
    return [size for text in (pdf, *inflated) for size in re.findall(pattern, text)]
