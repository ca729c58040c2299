"""Prior files on the command line: their effect, and errors."""

from __future__ import annotations

import io
import json
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import trundle
from tests.command import trundle as command
from trundle.cli import main

CONFIGS = Path(__file__).resolve().parents[2] / "configs"

SCENARIO = """
format = "trundle-scenario/1"
name = "prior"
object = "table.toml"
[[effect]]
kind = "viscous_wheel"
x = -0.5
y = 0.3
angle = 0.3
mu_x = 15.0
mu_y = 180.0
[tracker]
rate = 60.0
[random]
count = 2
duration = 3.0
speed = 0.3
spin = 0.5
"""

TABLE = """
format = "trundle-object/1"
name = "table"
source = "made up"
[body]
footprint = {footprint}
mass = 22.0
support = [[-0.5, -0.3], [0.5, -0.3], [0.3, 0.0], [-0.5, 0.3]]
"""
WHOLE = "[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a recording, `recording/`, of a table of 22 kg."""
    folder = tmp_path_factory.mktemp("priors")
    (folder / "table.toml").write_text(TABLE.format(footprint=WHOLE))
    (folder / "scenario.toml").write_text(SCENARIO)
    trundle.simulate(folder / "scenario.toml", seed=1).write(folder / "recording")
    return folder


class Ended(NamedTuple):
    """The end of a command."""

    returncode: int
    stdout: str
    stderr: str


def fit(folder: Path, prior: str, *options: str, starts: int = 3) -> Ended:
    """Run `trundle fit --prior` with the text of a prior file, in this process."""
    path = folder / "prior.toml"
    path.write_text(prior)
    places = [str(folder / "recording"), "--prior", str(path)]
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        status = main(["fit", *places, "--quiet", "--starts", str(starts), *options])
    return Ended(status, out.getvalue(), err.getvalue())


def fitted(folder: Path, prior: str, starts: int = 3) -> dict[str, Any]:
    """Return the summary of a successful fit."""
    ended = fit(folder, prior, "--json", starts=starts)
    assert ended.returncode == 0, ended.stderr
    summary: dict[str, Any] = json.loads(ended.stdout)
    return summary


@pytest.fixture(scope="module")
def plain(folder: Path) -> dict[str, Any]:
    """Return the summary of the fit with the prior of the catalogue."""
    return fitted(folder, "")


def means(summary: dict[str, Any]) -> dict[str, float]:
    """Return the identifiable estimates by name."""
    return {p["name"]: p["mean"] for p in summary["parameters"] if p["mean"] is not None}


def test_the_example_prior_changes_little_with_informative_data(folder: Path, plain: dict[str, Any]) -> None:
    example = (CONFIGS / "priors" / "office_table.toml").read_text()
    informed, uninformed = means(fitted(folder, example)), means(plain)
    assert uninformed["body.mass"] == pytest.approx(22, abs=0.3)
    assert informed == pytest.approx(uninformed, rel=1e-2)
    assert informed != uninformed


def test_a_fixed_value_is_kept_and_not_estimated(folder: Path) -> None:
    prior = '[body]\nmass = { distribution = "fixed", value = 23.5 }'
    ended = fit(folder, prior, "--out", str(folder / "fixed.toml"))
    assert ended.returncode == 0, ended.stderr
    assert "body.mass" not in ended.stdout
    mass = next(p for p in trundle.Model.read(folder / "fixed.toml").parameters if p["name"] == "body.mass")
    assert mass["value"] == 23.5


def test_an_informative_prior_shifts_the_estimate(folder: Path, plain: dict[str, Any]) -> None:
    """A prior as narrow as the likelihood puts the estimate between both."""
    mass = {p["name"]: p for p in plain["parameters"]}["body.mass"]
    mean, sd = mass["mean"] + 2 * mass["sd"], mass["sd"]
    pulled = fitted(folder, f'[body]\nmass = {{ distribution = "normal", mean = {mean}, sd = {sd} }}')
    found = {p["name"]: p for p in pulled["parameters"]}["body.mass"]
    # With a prior as precise as the data, the parameter is not identifiable and has no number.
    assert found["mean"] is None and not found["identifiable"]
    wider = fitted(folder, f'[body]\nmass = {{ distribution = "normal", mean = {mean}, sd = {4 * sd} }}')
    assert mass["mean"] < means(wider)["body.mass"] < mean


@pytest.mark.parametrize(
    ("prior", "words"),
    [
        (
            '[body]\nmass = { distribution = "normal", mean = 60, sd = 1 }',
            ["body.mass", "below its prior range [56, 64] kg"],
        ),
        (
            '[body]\nmass = { distribution = "uniform", low = 1, high = 15 }',
            ["body.mass", "above its prior range"],
        ),
        (
            '[viscous_wheel]\nx = { distribution = "uniform", low = 0.1, high = 0.6 }',
            ["viscous_wheel.x", "below its prior range"],
        ),
    ],
)
def test_a_prior_that_excludes_the_data_gives_no_number(folder: Path, prior: str, words: list[str]) -> None:
    summary = fitted(folder, prior)
    assert means(summary) == {}
    assert "the prior excludes the data" in summary["excluded_by_prior"][0]
    assert all(word in summary["excluded_by_prior"][0] for word in words), summary["excluded_by_prior"]


def test_a_prior_that_excludes_the_data_is_reported(folder: Path) -> None:
    ended = fit(folder, '[body]\nmass = { distribution = "normal", mean = 60, sd = 1 }')
    assert "the prior excludes the data" in ended.stdout
    assert "below its prior range [56, 64] kg" in ended.stdout
    assert "±" not in ended.stdout


def test_a_parameter_per_episode(folder: Path) -> None:
    # A wheel rotated by 90° with exchanged coefficients is the same; the range of the angle selects one.
    angle = 'angle = { distribution = "uniform", low = -0.4, high = 1.0 }'
    found = means(fitted(folder, f'[viscous_wheel]\n{angle}\nmu_y = {{ scope = "episode" }}'))
    own = [value for name, value in found.items() if name.startswith("viscous_wheel.mu_y[")]
    assert own == pytest.approx([180, 180], rel=0.05)
    assert own[0] != own[1]


@pytest.mark.parametrize(
    ("prior", "words"),
    [
        (
            "[body]\nmas = { distribution = 'angle' }",
            "prior.toml: body.mas: the model has no such parameter: did",
        ),
        (
            "[body]\nmass = { distribution = 'gauss' }",
            'body.mass: distribution = "gauss" is unknown: choose from',
        ),
        (
            "[body]\nmass = { distribution = 'normal', mean = 1, sd = -1 }",
            "body.mass: sd = -1: must be positive",
        ),
        (
            "[body]\nmass = { distribution = 'uniform', low = -1, high = 9 }",
            "body.mass: low = -1: must be in",
        ),
        (
            "[body]\nmass = { distribution = 'uniform', low = 9, high = 1 }",
            "low = 9, high = 1: low must be less",
        ),
        ("[body]\nmass = 20", "body.mass: is 20, not a prior: write"),
        ("[body\n", "prior.toml: TOML: "),
        (
            "[coulomb_friction]\nforce = { scope = 'episode' }",
            "coulomb_friction.force: the model has no such",
        ),
    ],
)
def test_an_unusable_prior_is_refused(folder: Path, prior: str, words: str) -> None:
    ended = fit(folder, prior)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert words in ended.stderr, ended.stderr


def test_a_missing_file_is_named(folder: Path) -> None:
    ended = command(folder, "fit", "recording", "--prior", "nowhere.toml")
    assert (ended.returncode, ended.stderr) == (
        2,
        "trundle: --prior = nowhere.toml: no such file or folder\n",
    )


def test_every_form_in_the_comments_of_the_example_is_valid(folder: Path) -> None:
    text = (CONFIGS / "priors" / "office_table.toml").read_text()
    forms = [
        line[2:].partition("}")[0] + "}" for line in text.partition("# Other forms:")[2].splitlines()[1:]
    ]
    assert len(forms) == 5
    for form in forms:
        table = "body" if form.startswith("mass") else "viscous_wheel"
        assert "scope" in form or "distribution" in form
        assert "parameters" in fitted(folder, f"[{table}]\n{form}", starts=1)
