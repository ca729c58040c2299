"""Detection of the layout of a CSV file: encoding, preamble, delimiter, decimal sign, header, units."""

from __future__ import annotations

import csv
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from trundle.importers.layout import SourceError
from trundle.importers.units import unit_in

__all__ = ["EMPTY", "Dialect", "detect", "is_number"]

SAMPLE_LINES = 200
"""Number of lines from which the layout is detected."""
MAX_PREAMBLE_LINES = 50
"""Maximum number of lines before the header."""
NUMERIC_SHARES = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5)
"""Shares of numbers in the rows of a table, in the order in which they are tried: others are columns of text,
such as names of episodes."""
DELIMITERS = (";", "\t", ",", "|", " ")
"""Delimiters in the order of preference: a comma may also be a decimal sign."""
EMPTY = ("", "nan", "null", "none", "na")
"""Cells without a value, in lower case."""


@dataclass(frozen=True)
class Dialect:
    """Layout of a CSV file; the fields are those of `DialectMap`.

    Attributes
    ----------
    encoding : str
        A codec of Python.
    delimiter : str
        Separator of cells.
    decimal : str
        "." or ",".
    header : bool
        Whether there is a row of column names.
    skip_rows : int
        Number of lines before the header, or before the first sample.
    unit_row : bool
        Whether the row below the header contains units.
    """

    encoding: str = "utf-8"
    delimiter: str = ","
    decimal: str = "."
    header: bool = True
    skip_rows: int = 0
    unit_row: bool = False


def detect(path: Path) -> Dialect:
    """Detect the layout of a file from its first lines.

    Raises
    ------
    SourceError
        If the file is empty, is not text, or contains no rows of numbers.
    """
    encoding = detect_encoding(path)
    lines = first_lines(path, encoding)
    if not any(line.strip() for line in lines):
        raise SourceError(path, "is empty; it must have a header and one row for each sample")
    for share in NUMERIC_SHARES:
        for delimiter in DELIMITERS:
            for decimal in (".", ",") if delimiter != "," else (".",):
                first = first_numeric_row(lines, delimiter, decimal, share)
                if first is not None:
                    return describe(lines, first, encoding, delimiter, decimal)
    raise SourceError(
        path,
        "has no rows of numbers separated by comma, semicolon, tab, | or space; export it as CSV",
    )


def detect_encoding(path: Path) -> str:
    """Return the encoding of a file: UTF-8 or UTF-16 by its byte-order mark, UTF-8 if valid, else Latin-1."""
    with path.open("rb") as file:
        head = file.read(1024)
        if head.startswith(b"\xef\xbb\xbf"):
            return "utf-8"
        if head.startswith((b"\xff\xfe", b"\xfe\xff")):
            return "utf-16"
        if b"\0" in head:
            raise SourceError(path, "is not a text file; export it as CSV")
    try:
        with path.open(encoding="utf-8") as text:
            for _ in text:
                pass
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"


def first_lines(path: Path, encoding: str) -> list[str]:
    """Return the first lines without line ends."""
    with path.open(encoding="utf-8-sig" if encoding == "utf-8" else encoding) as file:
        return [line.rstrip("\r\n") for line, _ in zip(file, range(SAMPLE_LINES), strict=False)]


def first_numeric_row(lines: list[str], delimiter: str, decimal: str, share: float) -> int | None:
    """Return the index of the first row of numbers, or None if these signs do not give a table of numbers.

    `share` of the cells of a row of numbers are numbers, the others text.
    """
    rows = [split(line, delimiter) for line in lines]
    numeric = [
        number
        for number, row in enumerate(rows)
        if len(row) > 1
        and sum(is_number(cell, decimal) for cell in row) >= share * len(row)
        and any(cell.strip() for cell in row)
    ]
    if not numeric or numeric[0] > MAX_PREAMBLE_LINES + 2:
        return None
    widths = Counter(len(rows[number]) for number in numeric)
    # Commas as decimal signs would give rows of different length, or cells such as "1,5" with a dot decimal.
    width, count = widths.most_common(1)[0]
    rest = [row for row in rows[numeric[0] :] if any(cell.strip() for cell in row)]
    if count < 0.5 * len(numeric) or sum(len(row) == width for row in rest) < 0.5 * len(rest):
        return None
    first = next(number for number in numeric if len(rows[number]) == width)
    above = [row for row in rows[:first] if any(cell.strip() for cell in row)]
    return first if not above or len(above[-1]) == width or delimiter in ";\t" else None


def describe(lines: list[str], first: int, encoding: str, delimiter: str, decimal: str) -> Dialect:
    """Return the layout of a table whose first row of numbers is `first`."""
    width = len(split(lines[first], delimiter))
    above = [number for number in range(first) if lines[number].strip()]
    fitting = [number for number in above if len(split(lines[number], delimiter)) == width]
    if not fitting:
        return Dialect(encoding, delimiter, decimal, header=False, skip_rows=first)
    unit_row = len(fitting) > 1 and is_unit_row(split(lines[fitting[-1]], delimiter))
    return Dialect(encoding, delimiter, decimal, True, fitting[-2 if unit_row else -1], unit_row)


def split(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line."""
    text = line.strip(" ") if delimiter == " " else line
    row = next(csv.reader([text], delimiter=delimiter, skipinitialspace=True), [])
    return [cell for cell in row if cell] if delimiter == " " else row


def is_unit_row(cells: list[str]) -> bool:
    """Return whether every cell is a unit, or empty, and at least two are units."""
    known = [unit_in(cell.strip().strip("[](){}")) for cell in cells]
    units = sum(unit is not None for unit in known)
    return units >= 2 and units >= 0.6 * len(cells)


def is_number(cell: str, decimal: str = ".") -> bool:
    """Return whether a cell is a number or has no value."""
    text = cell.strip()
    if text.lower() in EMPTY:
        return True
    sign = re.escape(decimal)
    return (
        re.fullmatch(rf"[+-]?(\d+({sign}\d*)?|{sign}\d+)([eE][+-]?\d+)?|[+-]?inf", text, re.ASCII) is not None
    )
