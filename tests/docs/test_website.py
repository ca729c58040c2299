"""The generated pages of the documentation site."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import trundle
from trundle.cli.commands import discover
from website import api, benchmark_tables, commands, effects, environments, links, offline, rust_source
from website.effect_push import effect_values, residual, simulate
from website.navigation import expand

KINDS = [effect["kind"] for effect in trundle.effects()]
CATALOGUE = {effect["kind"]: effect for effect in trundle.effects()}


@pytest.mark.parametrize("kind", KINDS)
def test_the_page_of_an_effect_is_complete(kind: str) -> None:
    page = effects.effect_page(CATALOGUE[kind])
    titles = re.findall(r"^## (.*)$", page, re.MULTILINE)
    expected = ["Law", "In a residual", "Push that shows it", "Detection", "Parameters", "In a model"]
    assert titles == expected
    assert "```text\n" in rust_source.law(kind), "no formula"
    for parameter in CATALOGUE[kind]["parameters"]:
        assert f"| `{parameter['name']}` | {parameter['unit']} |" in page
    (drawing,) = re.findall(r"<svg.*</svg>", page, re.DOTALL)
    assert len(list(ElementTree.fromstring(drawing))) > 20


def test_the_figure_of_an_effect_is_reproducible() -> None:
    first = effects.effect_page(CATALOGUE["caster_swivel"])
    simulate.cache_clear()
    assert effects.effect_page(CATALOGUE["caster_swivel"]) == first


@pytest.mark.parametrize("kind", KINDS)
def test_an_effect_shows_in_the_residual(kind: str) -> None:
    values = effect_values(CATALOGUE[kind])
    pushed = slice(120, -10)
    clean = np.abs(residual(simulate())[pushed]).max(axis=0)
    shown = np.abs(residual(simulate(("kind", kind), *values.items()))[pushed]).max(axis=0)
    assert clean.max() < 0.3
    assert (shown > [1.0, 1.0, 0.5]).any()


def test_the_residual_of_dry_friction_is_its_force() -> None:
    motion = simulate(("kind", "coulomb_friction"), *effect_values(CATALOGUE["coulomb_friction"]).items())
    force = np.hypot(*residual(motion)[200:400, :2].T)
    np.testing.assert_allclose(force, 8.0, rtol=0.02)


def test_detection_limits_are_those_of_the_benchmark() -> None:
    found = benchmark_tables.detection("latency")
    assert found is not None and "delay" in found.smallest and found.counts["1"] == "3/3"
    assert benchmark_tables.detection("cogging") is None
    assert "not measured" in effects.effect_page(CATALOGUE["cogging"])


@pytest.mark.parametrize("name", environments.environment_ids())
def test_the_page_of_an_environment_follows_the_template(name: str) -> None:
    page = environments.environment_page(name)
    parts = page.split("\n## ")[1:]
    assert [part.partition("\n")[0] for part in parts] == list(environments.TEMPLATE)
    assert all(len(part.partition("\n")[2].strip()) > 10 for part in parts)
    assert environments.picture(name).startswith(b"\x89PNG")


def test_every_registered_environment_has_a_page() -> None:
    paths = {path for path, _ in environments.environment_pages()}
    assert len(paths) == 1 + len(environments.environment_ids()) > 9


def test_the_reference_of_the_command_line_names_every_verb_and_argument() -> None:
    page = commands.command_page()
    assert set(re.findall(r"^## trundle (\S+)$", page, re.MULTILINE)) == set(discover())
    assert "`--model MODEL`" in page or "--model" in page
    assert page.count("```bash") == sum(hasattr(command, "EXAMPLE") for command in discover().values())


def test_patterns_of_the_navigation_expand_to_unlisted_pages() -> None:
    nav = ["index.md", {"A": ["a/index.md", "a/*", "a/none.md?"]}, {"B": ["b/*"]}, {"C": ["*.md"]}]
    pages = ["index.md", "a/index.md", "a/x.md", "c.md", "a/deep/y.md"]
    assert expand(nav, pages) == ["index.md", {"A": ["a/index.md", "a/x.md"]}, {"C": ["c.md"]}]


@pytest.mark.parametrize(
    ("link", "origin", "page", "expected"),
    [
        ("../ARCHITECTURE.md#x", "docs/a.md", "a.md", "project/architecture.md#x"),
        ("docs/a.md", "ARCHITECTURE.md", "project/architecture.md", "../a.md"),
        ("../configs/rl", "docs/a.md", "a.md", "source/configs/rl.md"),
        ("b.md#y", "docs/a.md", "a.md", "b.md#y"),
        ("https://example.org", "docs/a.md", "a.md", "https://example.org"),
        ("#z", "docs/a.md", "a.md", "#z"),
    ],
)
def test_links_lead_to_pages_of_the_site(link: str, origin: str, page: str, expected: str) -> None:
    assert links.rewrite(f"[text]({link})", origin, page) == f"[text]({expected})"


def test_files_that_documents_link_to_have_a_page() -> None:
    found = dict(links.source_files({"docs/a.md": "[demo](../configs/experiments/demo.toml)"}))
    assert "coulomb_friction" in found["source/configs/experiments/demo.toml.md"]


@pytest.mark.parametrize(
    ("page", "loads"),
    [
        ('<script src="https://a.org/x.js"></script>', ["https://a.org/x.js"]),
        ("<script type=module>import m from 'https://a.org/m.mjs'</script>", ["https://a.org/m.mjs"]),
        ('<script src="assets/x.js">const page = "https://a.org"</script>', []),
        ('<link rel="stylesheet" href="https://a.org/x.css">', ["https://a.org/x.css"]),
        ('<link rel="canonical" href="https://a.org/page">', []),
        ('<a href="https://a.org">text</a><img src="x.png">', []),
    ],
)
def test_resources_on_other_hosts_are_found(page: str, loads: list[str]) -> None:
    assert offline.remote_resources(page) == loads
    kept = 0 if loads else page.count("<script")
    assert offline.without_remote_scripts(page).count("<script") == kept


def test_generated_pages_are_not_committed() -> None:
    generated = {path for path, _ in [*api.api_pages(), *effects.effect_pages()]}
    assert not [path for path in generated if (Path(links.ROOT) / "docs" / path).exists()]
