"""The tutorials: executed notebooks without errors and without paths of a machine."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from trundle.cli.commands import discover

ROOT = Path(__file__).resolve().parents[2]
TUTORIALS = ROOT / "docs/tutorials"
NOTEBOOKS = sorted(TUTORIALS.glob("*.ipynb"))
MAX_BYTES = 300_000
MACHINE_PATH = re.compile(
    r"(?<![\w.])/(?:home|tmp|root|work|mnt|opt|usr|var|Users|private)/|[A-Z]:\\\\|site-packages"
)

pytestmark = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def cells_of(path: Path, kind: str) -> list[dict[str, Any]]:
    return [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == kind]


def source_of(cell: dict[str, Any]) -> str:
    return "".join(cell["source"])


def requires_extra(path: Path) -> bool:
    return bool(json.loads(path.read_text())["metadata"].get("trundle", {}).get("requires"))


def test_a_notebook_is_valid(path: Path) -> None:
    nbformat = pytest.importorskip("nbformat")
    nbformat.validate(nbformat.read(path, as_version=4))


def test_cells_are_executed_in_order(path: Path) -> None:
    counts = [cell["execution_count"] for cell in cells_of(path, "code")]
    unexecuted = [None] * len(counts)
    assert counts == list(range(1, len(counts) + 1)) or (requires_extra(path) and counts == unexecuted)


def test_no_output_is_an_error_or_a_warning(path: Path) -> None:
    outputs = [output for cell in cells_of(path, "code") for output in cell["outputs"]]
    assert [
        output for output in outputs if output["output_type"] == "error" or output.get("name") == "stderr"
    ] == []


def test_a_notebook_contains_no_path_of_a_machine(path: Path) -> None:
    cells = json.loads(path.read_text())["cells"]
    texts = [source_of(cell) for cell in cells]
    for cell in cells:
        for output in cell.get("outputs", []):
            data = {k: v for k, v in output.get("data", {}).items() if not k.startswith("image/png")}
            texts.append(json.dumps([output.get("text"), data], ensure_ascii=False))
    assert [found.group() for text in texts for found in MACHINE_PATH.finditer(text)] == []


def test_a_notebook_is_small(path: Path) -> None:
    assert path.stat().st_size < MAX_BYTES


def test_links_of_a_notebook_exist(path: Path) -> None:
    text = "\n".join(map(source_of, cells_of(path, "markdown")))
    targets = re.findall(r"\]\(([^)#\s]+)\)", text)
    assert [each for each in targets if "://" not in each and not (TUTORIALS / each).exists()] == []


def test_verbs_in_a_notebook_exist(path: Path) -> None:
    text = "\n".join(source_of(cell) for kind in ("markdown", "code") for cell in cells_of(path, kind))
    assert set(re.findall(r"^!?trundle ([a-z]+)", text, re.MULTILINE)) <= set(discover())
