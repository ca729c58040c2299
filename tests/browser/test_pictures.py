"""Screenshots and printed pages have content from top to bottom."""

from __future__ import annotations

import io
import re
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.browser.chromium import Browser

SIZES = {"desk": (1280, ""), "phone": (390, ""), "print": (794, "print")}
A4 = (595, 842)


def inked(png: bytes, band: int) -> list[float]:
    """Return the share of pixels that differ from the background, in each horizontal band of an image."""
    pixels = np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), dtype=np.int16)
    dark = np.abs(pixels - pixels[-1, -1]).max(axis=2) > 24
    return [float(dark[top : top + band].mean()) for top in range(0, len(dark) - band + 1, band)]


@pytest.mark.parametrize("size", sorted(SIZES))
def test_no_screen_of_the_page_is_blank(browser: Browser, page: Path, size: str) -> None:
    width, medium = SIZES[size]
    browser.emulate(medium)
    browser.open(page, width)
    bands = inked(browser.screenshot(), 700)
    browser.emulate()
    assert len(bands) > 2
    assert min(bands) > 0.004, bands


def test_a_blank_page_is_detected(browser: Browser, tmp_path: Path) -> None:
    blank = tmp_path / "blank.html"
    blank.write_text("<!doctype html><body style='height:2400px'>", encoding="utf-8")
    browser.open(blank, 390)
    assert max(inked(browser.screenshot(), 700)) == 0.0


def test_the_position_and_both_motions_are_visible(browser: Browser, table: Path) -> None:
    browser.open(table, 1280)
    pixels = np.asarray(Image.open(io.BytesIO(browser.screenshot())).convert("RGB"), dtype=np.int16)
    for name, colour in (("mark", 0xB0186F), ("before", 0xC04A00), ("after", 0x0059A8)):
        wanted = np.array([colour >> 16, colour >> 8 & 255, colour & 255])
        assert (np.abs(pixels - wanted).max(axis=2) < 12).sum() > 300, name


def test_it_prints_on_few_pages_without_blank_ones(browser: Browser, page: Path) -> None:
    browser.open(page, 1280)
    pdf = browser.pdf()
    sheets = [tuple(map(float, box)) for box in boxes(pdf)]
    assert 1 < len(sheets) <= 9
    assert all(size == pytest.approx(A4, abs=2) for size in sheets)
    drawn = contents(pdf)
    assert len(drawn) == len(sheets)
    assert all(stream.count(b"Tj") + stream.count(b"TJ") > 8 for stream in drawn)


def streams(pdf: bytes) -> dict[int, bytes]:
    """Streams of a file by the number of their object, inflated."""
    found = re.finditer(rb"\n(\d+) 0 obj\b(?:(?!endobj).)*?stream\r?\n(.*?)endstream", pdf, re.DOTALL)
    raw = {int(match[1]): match[2] for match in found}
    return {key: zlib.decompressobj().decompress(data) for key, data in raw.items() if data[:1] == b"\x78"}


def boxes(pdf: bytes) -> list[tuple[bytes, bytes]]:
    """Width and height in points of each page, from plain and compressed objects."""
    pattern = rb"/MediaBox\s*\[\s*0\s+0\s+([\d.]+)\s+([\d.]+)"
    return [size for text in (pdf, *streams(pdf).values()) for size in re.findall(pattern, text)]


def contents(pdf: bytes) -> list[bytes]:
    """What each page draws, in order."""
    inflated = streams(pdf)
    return [inflated[int(key)] for key in re.findall(rb"/Contents (\d+) 0 R", pdf)]
