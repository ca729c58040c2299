"""What the catalogue's Rust sources say about an effect: the law and the push that shows it."""

from __future__ import annotations

import re
from pathlib import Path

__all__ = ["law", "suggested_push"]

EFFECTS = Path(__file__).resolve().parents[1] / "env" / "model" / "src" / "effects"


def law(kind: str) -> str:
    """Return the documentation of an effect's law as Markdown."""
    lines = [line[3:].removeprefix(" ") for line in source(kind).splitlines() if line.startswith("//!")]
    text = re.sub(r"\[`super::(\w+)`\]", r"`\1`", "\n".join(lines))
    return text.strip()


def suggested_push(kind: str) -> str:
    """Return the push that identifies an effect best."""
    found = re.search(r'suggested_push:\s*"((?:[^"\\]|\\.)*)"', source(kind), re.DOTALL)
    if found is None:
        raise ValueError(f"{EFFECTS / kind}.rs: no suggested_push")
    return re.sub(r"\\\n\s*", "", found[1])


def source(kind: str) -> str:
    """Return the source of the law of an effect."""
    return (EFFECTS / f"{kind}.rs").read_text(encoding="utf-8")
