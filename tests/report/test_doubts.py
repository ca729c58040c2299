"""Ties with their certificate, rivals, and the push that would tell."""

from __future__ import annotations

import copy
import re

import pytest

from tests.report.answers import Sample
from tests.report.samples import certificate, experiment, push
from tests.report.test_page import words
from trundle.report import render
from trundle.report.figures import push as pushes
from trundle.report.given import Series


def section(page: str) -> str:
    """What the page says under the heading about alternatives."""
    found = re.search(r'<section id="doubts".*?</section>', page, re.DOTALL)
    return found[0] if found else ""


def test_a_tie_shows_certificate_and_push(samples: dict[str, Sample]) -> None:
    doubts = section(render(*samples["certified"]))
    text = words(doubts)
    assert "An offset of the force sensor, a sloping floor or a floor with a grain tied" in text
    assert text.count("Certificate: force_bias and floor_") == 2
    assert "To tell: First rotate the object by 90° to the left." in text
    assert 'id="push-0-0-0-title"' in doubts and 'id="push-0-0-1-title"' in doubts
    assert "Hold at (−0.60, 0.30)\xa0m, push towards −29°; object frame." in text
    assert "Hold at (0.55, −0.30)\xa0m and turn about there; object frame." in text


def test_certificates_of_others_stay_out(samples: dict[str, Sample]) -> None:
    diagnosis, series = copy.deepcopy(samples["tied"])
    series |= {
        "certificates": [certificate("force_bias", "latency"), certificate("force_bias")],
        "experiments": [experiment("force_bias", "latency")],
    }
    text = words(section(render(diagnosis, series)))
    assert "Certificate" not in text and "First turn it" not in text
    assert "No push is known that would tell." in text


def test_a_rival_takes_the_push_that_tells_it_from_what_is_named(samples: dict[str, Sample]) -> None:
    diagnosis, series = copy.deepcopy(samples["table"])
    series["experiments"] = [experiment("second_wheel", "coulomb_friction")]
    doubts = section(render(diagnosis, series))
    assert "push-0-0-title" in doubts and "push at (0.6, 0.0)" not in doubts
    series["experiments"] = [experiment("latency", "coulomb_friction")]
    assert "push at (0.6, 0.0)" in section(render(diagnosis, series))


def test_what_is_excluded_is_folded_away(samples: dict[str, Sample]) -> None:
    diagnosis, series = copy.deepcopy(samples["table"])
    diagnosis["alternatives"][0]["probability"] = 0.0001
    doubts = section(render(diagnosis, series))
    open_part, _, folded = doubts.partition("<details>")
    assert "No other explanation that was tried comes near." in open_part
    assert "A second wheel" in folded and "(&lt; 1 %)" in folded


def test_without_doubts_there_is_no_section(samples: dict[str, Sample]) -> None:
    diagnosis, series = copy.deepcopy(samples["table"])
    page = render(diagnosis | {"alternatives": [], "tied": [["only_one"]]}, series)
    assert section(page) == "" and 'href="#doubts"' not in page


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
def test_only_what_acts_is_drawn(
    samples: dict[str, Sample], knots: list[list[float]], lanes: list[str]
) -> None:
    drawing = pushes.draw("0", None, push("steady", knots), Series.parse(samples["table"][1]))
    assert drawing is not None
    assert re.findall(r'class="lane">([^<]*)<', drawing) == lanes


def test_a_push_without_a_grasp_is_not_drawn(samples: dict[str, Sample]) -> None:
    series = Series.parse(samples["table"][1])
    assert pushes.draw("0", None, push("steady", [], grasp=None), series) is None
    assert pushes.draw("0", None, push("steady", []), Series.parse({})) is None
