"""The recommended recordings are for kinds of regimes that the engines report."""

from __future__ import annotations

import re
from pathlib import Path

from trundle.joint_diagnosis import symptoms
from trundle.report import unexplained

ROOT = Path(__file__).resolve().parents[2]


def kinds(crate: str) -> set[str]:
    """Return the keywords of `RegimeKind` in the answer of a crate."""
    source = (ROOT / "adaptive" / crate / "src" / "answer.rs").read_text(encoding="utf-8")
    (body,) = re.findall(r"pub enum RegimeKind \{(.*?)\}", source, flags=re.S)
    variants = re.findall(r"^    (\w+),$", body, flags=re.M)
    return {re.sub(r"(?<!^)([A-Z])", r"_\1", variant).lower() for variant in variants}


def test_objects() -> None:
    recommended = {*unexplained._NEXT_IN_PLANE, *unexplained._NEXT_IN_TIME}
    assert kinds("diagnose") - recommended == {"all_speeds"}
    assert recommended <= kinds("diagnose")


def test_joints() -> None:
    assert kinds("mechanism") == set(symptoms.NEXT_RECORDINGS)
