"""Links, commands and tables of the documentation."""

import re
from pathlib import Path

import pytest

import trundle
from trundle.cli.commands import discover
from website import api, effects, environments

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
GENERATED = {
    ROOT / "docs" / next(pages())[0]
    for pages in (api.api_pages, effects.effect_pages, environments.environment_pages)
} | {ROOT / "docs" / "reference" / "command-line.md"}
"""Pages that the build of the site generates and that other pages link to."""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_targets_of_links_and_images_exist(page: Path) -> None:
    targets = re.findall(r"\]\(([^)#\s]+)\)", page.read_text())
    paths = [(page.parent / target).resolve() for target in targets if "://" not in target]
    assert [path for path in paths if not path.exists() and path not in GENERATED] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_verbs_of_commands_exist(page: Path) -> None:
    verbs = re.findall(r"^(?:\.venv/bin/)?trundle ([a-z]+)", page.read_text(), re.MULTILINE)
    assert set(verbs) <= set(discover())


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_make_targets_exist(page: Path) -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    assert set(re.findall(r"`?make ([a-z-]+)`", page.read_text())) <= targets


def test_every_effect_of_a_diagnosis_is_documented() -> None:
    named = {effect["effect"] for effect in trundle.effects()} - {"viscous_wheel"}
    section = (ROOT / "docs/diagnosis.md").read_text().split("## Effects")[1]
    assert set(re.findall(r"^\| `([a-z_]+)` \|", section, re.MULTILINE)) - {"effect"} == named
