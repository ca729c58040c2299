"""The catalogue in Python and on the command line."""

import json

import pytest

import trundle
from trundle.cli import main

KINDS = [effect["kind"] for effect in trundle.effects()]


def test_the_catalogue_contains_the_laws_of_the_paper() -> None:
    expected = {"viscous_wheel", "coulomb_friction", "support_friction", "force_bias", "floor_slope"}
    assert expected <= set(KINDS)


def test_every_parameter_is_documented() -> None:
    wheel = trundle.effects()[KINDS.index("viscous_wheel")]
    mu_x = next(p for p in wheel["parameters"] if p["name"] == "mu_x")
    assert (mu_x["unit"], mu_x["lower"], mu_x["neutral"], mu_x["default"]) == ("N·s/m", 0.0, 0.0, None)
    assert mu_x["prior"] == {"distribution": "log_normal", "median": 30.0, "sd": 2.0}
    assert wheel["acting"] == "object" and wheel["dissipative"]


@pytest.mark.parametrize("effect", trundle.effects(), ids=KINDS)
def test_every_kind_can_be_part_of_a_model(effect: dict[str, object]) -> None:
    text = f'format = "trundle-model/1"\n[body]\nmass = 1.0\n[[effect]]\nkind = "{effect["kind"]}"\n'
    parameters = trundle.Model.from_toml(text).parameters
    named = [f"{effect['kind']}.{p['name']}" for p in effect["parameters"]]  # type: ignore[attr-defined]
    assert [p["name"] for p in parameters] == ["body.mass", *named]


def test_the_catalogue_as_text(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects"]) == 0
    text = capsys.readouterr().out
    for effect in trundle.effects():
        for word in [effect["kind"], effect["summary"], *(p["name"] for p in effect["parameters"])]:
            assert word in " ".join(text.split())
    assert "N·s/m" in text and max(map(len, text.splitlines())) <= 120


def test_the_catalogue_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == [*trundle.effects(), *trundle.joint_effects()]
