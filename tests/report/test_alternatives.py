"""Ties with their certificates, competing effects, and discriminating pushes."""

from __future__ import annotations

import copy
import re

import pytest

from tests.report.answers import Sample
from tests.report.samples import certificate, experiment, push
from tests.report.test_page import words
from trundle.report import render
from trundle.report.figures import push as pushes
from trundle.report.series import Series


def section(page: str) -> str:
    """Return the section on alternative explanations; empty if there is none."""
    found = re.search(r'<section id="alternatives".*?</section>', page, re.DOTALL)
    return found[0] if found else ""


def test_a_tie_shows_certificate_and_push(samples: dict[str, Sample]) -> None:
    alternatives = section(render(*samples["certified"]))
    text = words(alternatives)
    assert "An offset of the force sensor, a sloping floor or a floor with a grain tied" in text
    assert text.count("Certificate: force_bias and floor_") == 2
    assert "To distinguish them: First rotate the object by 90° to the left." in text
    assert 'id="push-0-0-0-title"' in alternatives and 'id="push-0-0-1-title"' in alternatives
    assert "Grasp at (−0.60, 0.30)\xa0m and push towards −29° (object frame)." in text
    assert "Grasp at (0.55, −0.30)\xa0m and turn about that point (object frame)." in text


def test_certificates_of_other_models_are_omitted(samples: dict[str, Sample]) -> None:
    diagnosis, series = copy.deepcopy(samples["tied"])
    series |= {
        "certificates": [certificate("force_bias", "latency"), certificate("force_bias")],
        "experiments": [experiment("force_bias", "latency")],
    }
    text = words(section(render(diagnosis, series)))
    assert "Certificate" not in text and "First turn it" not in text
    assert "No push is known that distinguishes them." in text


def test_an_alternative_has_the_push_that_distinguishes_it_from_the_named_effect(
    samples: dict[str, Sample],
) -> None:
    diagnosis, series = copy.deepcopy(samples["table"])
    series["experiments"] = [experiment("second_wheel", "coulomb_friction")]
    alternatives = section(render(diagnosis, series))
    assert "push-0-0-title" in alternatives and "push at (0.6, 0.0)" not in alternatives
    series["experiments"] = [experiment("latency", "coulomb_friction")]
    assert "push at (0.6, 0.0)" in section(render(diagnosis, series))


def test_excluded_explanations_are_collapsed(samples: dict[str, Sample]) -> None:
    diagnosis, series = copy.deepcopy(samples["table"])
    diagnosis["alternatives"][0]["probability"] = 0.0001
    open_part, _, folded = section(render(diagnosis, series)).partition("<details>")
    assert "No other tested explanation is plausible." in open_part
    assert "A second wheel" in folded and "(&lt; 1 %)" in folded


def test_without_alternatives_there_is_no_section(samples: dict[str, Sample]) -> None:
    diagnosis, series = copy.deepcopy(samples["table"])
    page = render(diagnosis | {"alternatives": [], "tied": [["only_one"]]}, series)
    assert section(page) == "" and 'href="#alternatives"' not in page


@pytest.mark.parametrize(
    ("knots", "lanes"),
    [
        ([[0.0, 0.0, 0.0, 0.0], [1.0, 20.0, 0.0, 0.0]], ["force along the arrow, N"]),
        ([[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 3.0]], ["torque, N·m"]),
        ([[0.0, 1.0, 0.0, 2.0], [1.0, 20.0, 0.0, 3.0]], ["force along the arrow, N", "torque, N·m"]),
        ([[0.0, 1.0, 0.0, 2.0]], []),
        ([[1.0, 1.0, 0.0, 2.0], [1.0, 2.0, 0.0, 0.0]], []),
    ],
)
def test_channels_that_are_zero_are_not_drawn(
    samples: dict[str, Sample], knots: list[list[float]], lanes: list[str]
) -> None:
    figure = pushes.draw("0", None, push("steady", knots), Series.parse(samples["table"][1]))
    assert figure is not None
    assert re.findall(r'class="lane">([^<]*)<', figure.drawing) == lanes


def test_a_push_without_a_grasp_is_not_drawn(samples: dict[str, Sample]) -> None:
    series = Series.parse(samples["table"][1])
    assert pushes.draw("0", None, push("steady", [], grasp=None), series) is None
    assert pushes.draw("0", None, push("steady", []), Series.parse({})) is None
