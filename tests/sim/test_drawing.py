"""Images of the environments, and their window."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from gymnasium.error import DependencyNotInstalled
from numpy.typing import NDArray

from trundle.envs.drawing import EXTENT, picture
from trundle.envs.scene import Disc, Shape, View
from trundle.envs.window import Window

TABLE = Shape((((-0.6, -0.4), (0.6, -0.4), (0.6, 0.4), (-0.6, 0.4)),), ((0.5, 0.3), (-0.5, -0.3)))
DESK = Shape((((-0.8, -0.8), (0.8, -0.8), (0.8, -0.2), (-0.2, -0.2), (-0.2, 0.8), (-0.8, 0.8)),))
CHAIR = Shape((Disc((0.0, 0.0), 0.5), ((-0.7, -0.3), (-0.4, -0.3), (-0.4, 0.3), (-0.7, 0.3))))
BOX = ((-1.5, 1.0), (-0.5, 1.0), (-0.5, 2.0), (-1.5, 2.0))
AWAY = View((-50.0, 0.0, 0.0), TABLE)
"""A view of the bare floor."""

Pixels = NDArray[np.uint8]


def pixel(pixels: Pixels, x: float, y: float, arena: float = 2.5) -> list[int]:
    extent, size = EXTENT * arena, len(pixels)
    row, column = (extent - y) / (2 * extent) * size, (extent + x) / (2 * extent) * size
    return [int(value) for value in pixels[int(row), int(column)]]


def is_floor(colour: list[int]) -> bool:
    return min(colour) > 215


def is_brown(colour: list[int]) -> bool:
    return colour[0] > colour[1] + 20 > colour[2] + 40


def is_green(colour: list[int]) -> bool:
    return colour[1] > colour[0] + 20 and colour[1] > colour[2]


def changed(view: View, **what: Any) -> NDArray[np.bool_]:
    """Return where an image changes with the view."""
    different: NDArray[np.bool_] = np.any(picture(view) != picture(replace(view, **what)), axis=2)
    return different


def test_object_goal_and_obstacle_are_at_their_positions() -> None:
    pixels = picture(View((1.0, 0.5, np.pi / 2), TABLE, goal=(-1.0, -0.5, 0.0), obstacles=(BOX,)))
    assert is_brown(pixel(pixels, 1.2, 1.0)), "the table, turned"
    assert is_floor(pixel(pixels, 1.6, 0.7)), "where it would be unturned"
    assert is_green(pixel(pixels, -1.3, -0.7))
    wall = pixel(pixels, -1.2, 1.3)
    assert np.ptp(wall) < 15 and 100 < wall[0] < 200
    assert is_floor(pixel(pixels, 0.25, 1.25))


@pytest.mark.parametrize("turn", [0.0, 2.0])
def test_the_notch_of_a_desk_shows_the_floor(turn: float) -> None:
    pixels = picture(View((0.0, 0.0, turn), DESK))
    cos, sin = np.cos(turn), np.sin(turn)

    def seen(x: float, y: float) -> list[int]:
        return pixel(pixels, cos * x - sin * y, sin * x + cos * y)

    assert is_floor(seen(0.45, 0.45))
    assert is_brown(seen(-0.5, 0.5)) and is_brown(seen(0.5, -0.5)) and is_brown(seen(-0.5, -0.5))


def test_a_chair_is_round_and_has_a_back() -> None:
    pixels = picture(View((0.0, 0.0, 0.0), CHAIR))
    assert is_brown(pixel(pixels, -0.1, 0.4)) and is_brown(pixel(pixels, -0.55, 0.2))
    assert is_floor(pixel(pixels, 0.45, 0.45))


def test_a_tip_is_drawn_at_its_contact_and_a_clamp_is_larger() -> None:
    tip = changed(AWAY, gripper=(1.0, 0.5, 0.0), holds=False)
    clamp = changed(AWAY, gripper=(1.0, 0.5, 0.0), holds=True)
    blue = pixel(picture(replace(AWAY, gripper=(1.0, 0.5, 0.0), holds=False)), 1.0, 0.5)
    assert blue[2] > blue[0] + 100
    assert 4 < tip.sum() < clamp.sum()


def test_the_length_of_an_arrow_is_proportional_to_the_force() -> None:
    ends = []
    for force in (50.0, 100.0):
        columns = np.flatnonzero(
            changed(replace(AWAY, gripper=(-1.0, 0.0, 0.0)), wrench=(force, 0.0, 0.0)).any(axis=0)
        )
        ends.append((columns[-1] + 1) / 480 * 5.5 - 2.75)
    np.testing.assert_allclose(ends, [-0.6, -0.2], atol=0.05)


def test_the_torques_sign_mirrors_its_arrow() -> None:
    def arrow(torque: float) -> Pixels:
        return picture(replace(AWAY, gripper=(0.0, 0.0, 0.0), wrench=(0.0, 0.0, torque)))

    left, right = arrow(20.0), arrow(-20.0)
    assert not np.array_equal(left, right)
    np.testing.assert_allclose(left[::-1].astype(int), right, atol=1)
    first, last = left[:240], left[240:]
    heads = [(np.abs(half.astype(int) - (208, 52, 28)).sum(axis=2) < 30).sum() for half in (first, last)]
    assert heads[1] > heads[0], "a positive torque turns left: behind the gripper its head is to the right"


def test_path_and_trail_run_through_their_points() -> None:
    through = ((-2.0, -1.0), (0.0, 1.3), (2.0, -1.0))
    path, trail = changed(AWAY, path=through), changed(AWAY, trail=through)
    for x, y in through[:2]:
        near = slice(int((2.6 - y) / 5.5 * 480), int((2.9 - y) / 5.5 * 480))
        across = slice(int((x + 2.6) / 5.5 * 480), int((x + 2.9) / 5.5 * 480))
        assert path[near, across].any() and trail[near, across].any()
    assert path.sum() < 1.2 * trail.sum(), "dashed, though wider"


def test_a_hidden_wheel_is_drawn_only_if_revealed() -> None:
    view = View((1.0, 0.0, np.pi / 2), TABLE)
    mark = changed(view, revealed=((0.5, 0.3, 0.0, ""),))
    rows, columns = np.nonzero(mark)
    np.testing.assert_allclose([columns.mean(), rows.mean()], [3.45 / 5.5 * 480, 2.25 / 5.5 * 480], atol=1.5)
    assert changed(view, revealed=((0.5, 0.3, 0.0, "locked"),)).sum() > mark.sum() + 100


def test_a_view_gives_the_same_bytes_in_a_fresh_array() -> None:
    view = View((0.1, 0.2, 0.3), DESK, goal=(1.0, 0.0, 0.0), obstacles=(BOX,), gripper=(0.0, 0.0, 1.0))
    first = picture(view)
    kept = first.tobytes()
    first[:] = 0
    assert picture(view).tobytes() == kept


def test_outside_objects_are_clipped() -> None:
    bare = picture(AWAY)
    for x, y in ((2.6, 2.6), (-2.6, 2.6), (2.6, -2.6), (-2.6, -2.6)):
        pose = (x, y, 0.7)
        pixels = picture(
            View(
                pose,
                CHAIR,
                goal=pose,
                gripper=pose,
                wrench=(900.0, 900.0, 900.0),
                revealed=((0, 0, 0, "ab"),),
            )
        )
        assert not np.array_equal(pixels, bare)
    far, box = (1e6, -1e6, 1.0), ((50.0, 50.0), (60.0, 50.0), (55.0, 60.0))
    view = View(far, DESK, far, (box,), (), far, False, (9.0, 9.0, 9.0), revealed=((0.0, 0.0, 0.0, "far"),))
    np.testing.assert_array_equal(picture(view), bare)


@pytest.mark.parametrize("size", [64, 480, 721])
@pytest.mark.parametrize("arena", [1.5, 4.0])
def test_size_and_arena_are_used(size: int, arena: float) -> None:
    pixels = picture(View((1.0, 0.5, 0.0), TABLE, arena=arena), size)
    assert pixels.shape == (size, size, 3) and pixels.dtype == np.uint8
    assert is_brown(pixel(pixels, 1.25, 0.7, arena)) and not is_brown(pixel(pixels, 0.0, -1.0, arena))


@pytest.fixture
def pygame(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    module = pytest.importorskip("pygame", reason="the window needs pygame: pip install trundle[human]")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    yield module
    module.display.quit()


def test_a_window_keeps_its_frame_rate(pygame: Any) -> None:
    window, pixels = Window(), picture(View((1.0, 0.5, 0.0), TABLE))
    window.show(pixels, 50)
    begun = time.monotonic()
    for _ in range(5):
        window.show(pixels, 50)
    assert time.monotonic() - begun > 0.08
    shown = pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1)
    np.testing.assert_array_equal(shown, pixels)
    window.close()
    window.close()
    assert window.closed and not pygame.display.get_init()


def test_a_closed_window_stays_closed(pygame: Any) -> None:
    window, pixels = Window(), picture(AWAY, 64)
    window.show(pixels, 1000)
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    for _ in range(2):
        window.show(pixels, 1000)
    assert window.closed and not pygame.display.get_init()


def test_a_missing_pygame_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(DependencyNotInstalled, match=r"pip install 'trundle\[human\]'"):
        Window()
