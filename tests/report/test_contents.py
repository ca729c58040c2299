"""The page shows the content of diagnosis.json: warnings, immaterial effects, ties, residuals, wheels."""

from __future__ import annotations

import copy
import re
from typing import Any

import pytest

import trundle
from tests.report.answers import Sample, measure, unexplained_sample
from tests.report.test_page import words
from trundle.report import render
from trundle.report.figures import wheels
from trundle.report.statement import parameters_not_in_statement
from trundle.report.wording import effect_name

WINDOW = {"episode": "episode_04", "start": 0.7, "end": 1.3, "strength": 9.0}
PERIOD = {"of": "position", "period": 0.0025, "unit": "m", "amplitude": 0.8}
LEFT = {"force_rms": 0.41, "torque_rms": 0.052, "share": 0.04, "regime": "above 0.25 m/s"}


def part(page: str, identity: str) -> str:
    """Return a section of the page."""
    found = re.search(rf'<section id="{identity}".*?</section>', page, re.DOTALL)
    return found[0] if found else ""


@pytest.fixture
def table(samples: dict[str, Sample]) -> Sample:
    diagnosis, series = copy.deepcopy(samples["table"])
    diagnosis["residual"] = {**LEFT, "windows": [WINDOW], "periods": [PERIOD]}
    return diagnosis, series


def test_warnings_come_before_all_sections(table: Sample) -> None:
    diagnosis, series = table
    warning = "episode_05 (held out) behaves unlike the training episodes"
    page = render(diagnosis | {"warnings": [warning]}, series)
    assert 'role="note"' in page
    assert page.index("behaves unlike") < page.index("<h2")
    assert 'role="note"' not in render(diagnosis | {"warnings": []}, series)


def test_the_residual_is_that_of_the_model_with_the_named_effects(table: Sample) -> None:
    section = part(render(*table), "residual")
    shown, _, folded = section.partition("Before: missing wrench of the refitted simulation")
    text = re.sub(r"<[^>]*>", " ", shown)
    assert "Size (RMS): a force of 0.41\xa0N and a torque of 0.052\xa0N·m, 4 % of the initial misfit." in text
    assert "It occurs above 0.25 m/s." in text and "below 0.03 m/s" not in words(section)
    assert "It is periodic in position: period 2.5\xa0mm, amplitude 0.80\xa0N." in text
    assert "after whole" in shown and "before whole" not in shown
    assert "before whole" in folded and "after whole" not in folded
    assert "episode_04" in text and "0.70\N{EN DASH}1.30" in text


def test_the_residual_after_has_its_own_band(table: Sample) -> None:
    diagnosis, series = table
    narrow = copy.deepcopy(series)
    for episode in narrow["episodes"]:
        residual = episode["residual"]
        residual["sd_after"] = [[0.01 * value for value in row] for row in residual["sd"]]
    section, other = (part(render(diagnosis, given), "residual") for given in (series, narrow))
    bands = [re.findall(r'<path d="([^"]*)" class="band"', page) for page in (section, other)]
    assert bands[0][1] != bands[1][1], "the band of the simulation without the effect"


def test_immaterial_effects_have_a_table_with_the_reason(table: Sample) -> None:
    diagnosis, series = table
    small = {"effect": "mass_change", "probability": 0.97, "statement": "A load of 0.29 ± 0.05 kg is put on."}
    text = words(part(render(diagnosis | {"immaterial": [small]}, series), "immaterial"))
    assert "A change of load A load of 0.29 ± 0.05\xa0kg is put on. 97 %" in text
    assert "Left-out episodes are predicted almost as well without them" in text
    assert part(render(diagnosis, series), "immaterial") == ""


def test_tied_sets_show_every_set_and_the_discriminating_push(table: Sample) -> None:
    diagnosis, series = table
    sets = [["coulomb_friction"], ["force_bias", "floor_slope"]]
    rival = {"effect": "force_bias + floor_slope", "probability": 0.3, "experiment": "turn it by a quarter"}
    page = render(diagnosis | {"tied_sets": [sets], "alternatives": [rival]}, series)
    text = words(part(page, "alternatives"))
    assert "Dry friction or an offset of the force sensor with a sloping floor tied sets" in text
    assert text.count("turn it by a quarter.") == 1
    assert "This recording cannot distinguish these alternatives: dry friction or an offset" in words(page)


def test_an_unexplained_page_lists_symptoms_and_the_next_recording(samples: dict[str, Sample]) -> None:
    diagnosis, series = copy.deepcopy(samples["unexplained"])
    regime = "in all motions, as a force constant in the world along 40°"
    diagnosis["mismatch"]["regime"] = regime
    diagnosis["residual"] = {**LEFT, "share": 1.0, "regime": regime, "regime_kind": "constant_in_world"}
    series["candidates"][0]["reason"] = "the data do not identify a parameter that defines an effect"
    page = render(diagnosis, series)
    known = words(part(page, "symptoms"))
    for sentence in (
        "It acts near (−0.45, 0.30)\xa0m on the object.",
        "It exceeds the noise in 3 windows of 2 episodes, 3.4\xa0s in total.",
        "It is strongest in episode_05 at 0.60",
        "Size (RMS): a force of 0.41\xa0N and a torque of 0.052\xa0N·m.",
        f"It occurs {regime}.",
        "4 models with further effects were fitted and rejected. Closest: dry friction. "
        "It is rejected because the data do not identify a parameter that defines an effect.",
        "Turn the object by 90° and repeat the same pushes",
    ):
        assert sentence in known
        assert words(page).count(sentence) == 1
    tried = words(part(page, "ranking"))
    assert "the data do not identify a parameter that defines an effect" in tried
    assert "99" not in tried, "odds among wrong laws read as certainty"
    assert "its residual exceeds what noise explains" in tried
    diagnosis["alternatives"] = [{"effect": "tether", "probability": 0.0, "experiment": "let go"}]
    assert "plausible" not in words(render(diagnosis, series))


def test_equal_results_before_and_after_are_shown_once() -> None:
    diagnosis, series = unexplained_sample()
    for side in diagnosis["fit"].values():
        side["after"] = dict(side["before"])
    diagnosis["nominal"]["after"] = diagnosis["nominal"]["before"]
    for episode in series["episodes"]:
        episode["after"], episode["residual"]["after"] = episode["before"], episode["residual"]["before"]
    page = render(diagnosis, series)
    assert 'scope="col">after<' not in page and 'class="after' in page and 'class="before' not in page
    assert "not enough" not in words(page)


def test_the_table_omits_the_metric_in_the_headline(table: Sample) -> None:
    page = render(*table)
    assert "12.3\xa0cm" in words(page) and "12.3" not in words(part(page, "fit"))


def test_a_number_of_the_statement_is_not_repeated_on_the_card() -> None:
    statement = "Dry friction of 14.01 ± 0.05 N acts at (0.500 ± 0.003 m, -0.299 ± 0.002 m)."
    parameters = {"force": measure(14.013, 0.05, "N"), "static_force": measure(14.2, 0.5, "N")}
    assert list(parameters_not_in_statement(parameters, statement)) == ["static_force"]
    assert list(
        parameters_not_in_statement(
            {"x": measure(-0.2994, 0.0018, "m"), "y": measure(0.2994, 0.1, "m")}, statement
        )
    ) == ["y"]


def test_fitted_wheels_are_on_the_map(table: Sample) -> None:
    diagnosis, series = table
    names = {"x": measure(-0.5, 0.01, "m"), "y": measure(0.3, 0.01, "m"), "angle": measure(0.3, 0.1, "rad")}
    after = {f"viscous_wheel.{name}": value for name, value in names.items()}
    nominal: dict[str, Any] = {"given": {}, "before": {}, "after": after}
    page = render(diagnosis | {"nominal": nominal}, series)
    assert page.count('class="wheel"') == 1 and "the fitted wheel." in words(page)
    after["viscous_wheel.x"] = measure(None, None, "m", identifiable=False)
    assert wheels.known_wheels(nominal) == []
    given = {
        f"viscous_wheel.{name}": value["mean"] for name, value in names.items() if value["mean"] is not None
    }
    assert wheels.known_wheels({"given": {**given, "viscous_wheel.x": -0.1}})[0].position.tolist() == [
        -0.1,
        0.3,
    ]


def test_every_effect_of_the_catalogue_has_a_name() -> None:
    blocks = {"viscous_wheel", "support_friction", "support_drag", "spin_drag"}
    for name in trundle.effects():
        kind = str(name["kind"] if isinstance(name, dict) else name)
        assert kind in blocks or effect_name(kind) != kind.replace("_", " ") or kind == "doorsill", kind


@pytest.mark.parametrize(
    ("pose", "text"), [("own_time", "at the time of each wrench"), ("latest", "latest recorded pose")]
)
def test_the_pose_that_transforms_wrenches_is_stated(table: Sample, pose: str, text: str) -> None:
    diagnosis, series = table
    assert text in words(part(render(diagnosis | {"wrench_pose": pose}, series), "reproduce"))
