"""The maps of the floor and of the object, and the pose at an event."""

from __future__ import annotations

import copy
import re

import numpy as np
import pytest

from tests.report.answers import Sample
from tests.report.effects import effect_sample
from tests.report.test_page import words
from trundle.report import render
from trundle.report.figures import floor_map, missing_force, motion, object_map
from trundle.report.figures.top_view import TopView
from trundle.report.location import Event
from trundle.report.series import Episode, Series


def still(**more: object) -> Episode:
    """An episode of three samples, the heading past a half turn."""
    given = {"name": "e", "t": [0.0, 1.0, 2.0], "observed": [[0, 0, 3.1], [1, 0, -3.1], [2, 0, -3.0]], **more}
    return Series.parse({"episodes": [given]}).episodes[0]


def test_a_pose_is_interpolated_and_turns_the_short_way() -> None:
    pose = motion.pose_at_event(Event("e", 0.5, None), still())
    assert pose is not None
    assert pose[:2].tolist() == [0.5, 0.0]
    assert abs(np.cos(pose[2]) + 1.0) < 1e-3, "it turned through zero"
    assert motion.pose_at_event(Event("another", 0.5, None), still()) is None
    assert motion.pose_at_event(Event("e", 0.5, None), still(observed=[None, None, None])) is None


@pytest.mark.parametrize(
    ("effects", "maps"),
    [
        (("coulomb_friction",), ["object"]),
        (("tether",), ["object", "floor"]),
        (("floor_patch",), ["floor"]),
        (("floor_slope",), ["floor"]),
        (("wheel_event",), ["floor"]),
        (("latency",), ["object"]),
        (("com_offset", "obstacle_contact"), ["object", "floor"]),
    ],
)
def test_the_header_shows_the_map_that_has_something_to_mark(
    effects: tuple[str, ...], maps: list[str]
) -> None:
    page = render(*effect_sample(*effects))
    assert re.findall(r'id="(object|floor)-title"', page) == maps


def test_the_region_of_an_unexplained_wrench_is_drawn(samples: dict[str, Sample]) -> None:
    diagnosis, series = samples["discrepancy"]
    text = words(render(diagnosis, series))
    assert "It acts in a region of 1.00 by 1.10\xa0m about (1.00, 0.15)\xa0m on the floor." in text
    assert "with a force that is learned from the training data and depends on" in text
    named = diagnosis | {"verdict": "consistent"}
    assert floor_map.draw(named, Series.parse(series)) is None and object_map.hint_point(named) is None


def test_arrows_point_along_the_missing_force(samples: dict[str, Sample]) -> None:
    lacking = {"t": [0.0, 1.0, 2.0], "before": [[9.0, 0, 0], [1.0, 0, 0], [0, 5.0, 0]], "sd": [[1.0] * 3] * 3}
    quarter = [[0.0, 0.0, np.pi / 2], [1.0, 0.0, np.pi / 2], [2.0, 0.0, np.pi / 2]]
    episode = still(observed=quarter, residual=lacking)
    plan = TopView.around([episode.observed[:, :2]])
    arrows, longest = missing_force.arrows(plan, [episode])
    assert longest == pytest.approx(9.0)
    lines = [tuple(map(float, re.findall(r"-?[\d.]+", arrow)[:4])) for arrow in arrows]
    assert len(lines) == 2, "what noise explains is drawn"
    (x0, y0, x1, y1), (x2, y2, x3, y3) = lines
    assert x1 == pytest.approx(x0, abs=0.2) and y0 - y1 == pytest.approx(46.0, abs=0.2), "a force along y"
    assert y2 == pytest.approx(y3, abs=0.2) and x2 - x3 == pytest.approx(46.0 * 5 / 9, abs=0.2)


def test_an_event_comes_first_and_is_marked_in_time_and_place() -> None:
    page = render(*effect_sample("mass_change"))
    first = page[page.index('id="motion-0-title"') : page.index('id="motion-1-title"')]
    assert "Motion in episode_05" in first and first.count('class="event"') == 2
    assert first.count('class="mark hollow"') == 2
    assert ">1</text>" in first


def test_numbers_of_close_points_do_not_overlap(samples: dict[str, Sample]) -> None:
    diagnosis, series = samples["corners"]
    figure = object_map.draw(diagnosis, Series.parse(series))
    assert figure is not None
    spots = re.findall(r'<text x="([\d.]+)" y="([\d.]+)" class="number"', figure.drawing)
    places = np.array(spots, dtype=np.float64)
    apart = np.abs(places[:, None] - places[None]).max(axis=2) + 99.0 * np.eye(len(places))
    assert len(places) == 5 and apart.min() > 15.0


def test_a_map_of_places_far_away_still_shows_the_object() -> None:
    diagnosis, series = copy.deepcopy(effect_sample("coulomb_friction"))
    diagnosis["missing"][0]["where"]["body_point"]["mean"] = [80.0, 3.0]
    figure = object_map.draw(diagnosis, Series.parse(series))
    assert figure is not None and ">20\xa0cm<" in figure.drawing
