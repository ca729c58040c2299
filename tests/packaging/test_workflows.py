"""The GitHub workflows: valid files, pinned actions, all platforms and versions of Python."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[2]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
FORMS = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"))


def load(path: Path) -> dict[Any, Any]:
    """Return the content of a YAML file."""
    content: dict[Any, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
    return content


def workflow(name: str) -> dict[Any, Any]:
    """Return the jobs of a workflow."""
    jobs: dict[Any, Any] = load(ROOT / ".github" / "workflows" / f"{name}.yml")["jobs"]
    return jobs


def steps(path: Path) -> Iterator[dict[str, Any]]:
    """Yield all steps of a workflow."""
    for job in load(path)["jobs"].values():
        yield from job.get("steps", [])


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_a_workflow_is_complete(path: Path) -> None:
    content = load(path)
    assert content[True], "no trigger"  # YAML 1.1 reads the key `on` as a boolean
    assert content["permissions"] == {"contents": "read"}
    for job in content["jobs"].values():
        assert set(job.get("needs", "").split()) <= set(content["jobs"])
        if "uses" in job:
            assert (ROOT / job["uses"]).is_file()
        else:
            assert job["runs-on"] and job["steps"] and 0 < job["timeout-minutes"] <= 60


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_actions_are_pinned_to_a_version(path: Path) -> None:
    used = [step["uses"] for step in steps(path) if "uses" in step]
    assert [action for action in used if not re.fullmatch(r"[\w-]+/[\w-]+@v\d+\.\d+\.\d+", action)] == []


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_commands_name_existing_targets_and_files(path: Path) -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for command in (step["run"] for step in steps(path) if "run" in step):
        for target in re.findall(r"\bmake ([a-z-]+)", command):
            assert re.search(rf"^{target}:", makefile, flags=re.M), target
        for file in re.findall(r"\S+\.(?:py|lock)\b", command):
            assert (ROOT / file).is_file(), file


def test_tests_run_on_every_supported_python() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    prefix = "Programming Language :: Python :: 3."
    supported = [name.removeprefix(prefix) for name in project["classifiers"] if name.startswith(prefix)]
    tested = workflow("ci")["python"]["strategy"]["matrix"]["python"]
    assert tested == [f"3.{minor}" for minor in supported]
    assert project["requires-python"] == f">={tested[0]}"


def test_wheels_are_built_and_tried_on_every_platform() -> None:
    job = workflow("wheels")["wheel"]
    assert {each["target"] for each in job["strategy"]["matrix"]["include"]} == {
        "aarch64-apple-darwin",
        "aarch64-unknown-linux-gnu",
        "x86_64-apple-darwin",
        "x86_64-pc-windows-msvc",
        "x86_64-unknown-linux-gnu",
    }
    assert any(".ci/check_wheel.py" in step.get("run", "") for step in job["steps"])


def test_a_release_publishes_with_a_trusted_publisher_and_attestations() -> None:
    jobs = workflow("release")
    assert jobs["wheels"]["uses"] == "./.github/workflows/wheels.yml"
    assert jobs["publish"]["permissions"] == {
        "attestations": "write",
        "contents": "write",
        "id-token": "write",
    }
    text = (ROOT / ".github" / "workflows" / "release.yml").read_text(encoding="utf-8")
    assert "secrets." not in text


@pytest.mark.parametrize("path", FORMS, ids=lambda path: path.stem)
def test_an_issue_form_is_complete(path: Path) -> None:
    form = load(path)
    if path.stem == "config":
        assert form["contact_links"]
        return
    assert form["name"] and form["description"]
    identifiers = [field["id"] for field in form["body"]]
    assert len(set(identifiers)) == len(identifiers)
    assert all(field["attributes"]["label"] for field in form["body"])
