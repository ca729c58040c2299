"""Writing of a scene to a Rerun recording.

Everything over time is written by columns. Two timelines exist: `time`, on which the episodes follow each
other with a gap of at least a second, and `episode`, the index of the episode in that order.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from trundle._native import __version__
from trundle._optional import require
from trundle.viewing.geometry import lift, object_outlines, wheel_outline
from trundle.viewing.layout import blueprint
from trundle.viewing.scene import (
    Arrow,
    Episode,
    Floats,
    Motion,
    Scene,
    Wheel,
    Window,
    metres_per_newton,
    scene_size,
)
from trundle.viewing.style import COLOURS, Colour, curve_path, curve_styles

__all__ = ["write_rrd"]

APPLICATION = "trundle"
TIME, EPISODE = "time", "episode"
GAP_S = 1.0
"""Shortest gap between two episodes on the timeline `time`, s."""
SUMMARY = "/summary"
LINE_PIXELS, ARROW_PIXELS, POINT_PIXELS = -1.5, -3.0, -5.0
"""Radii; negative numbers are pixels on the screen for the viewer."""


def write_rrd(scene: Scene, path: Path) -> None:
    """Write a scene to an .rrd file.

    Raises
    ------
    TrundleError
        If rerun-sdk is not installed.
    """
    rr = require("rerun", "rerun", "Rerun recordings")
    identity = hashlib.sha256(f"{scene.name}\n{scene.summary}".encode()).hexdigest()[:32]
    stream = rr.RecordingStream(APPLICATION, recording_id=identity, send_properties=False)
    stream.set_log_time_enabled(False)
    stream.set_log_tick_enabled(False)
    stream.save(path, default_blueprint=blueprint(scene))
    try:
        stream.send_recording_name(scene.name)
        Writer(rr, stream, scene).write()
        stream.flush()
    finally:
        stream.disconnect()


class Writer:
    """Writes the parts of a scene to an open stream.

    Parameters
    ----------
    rr : module
        The module `rerun`.
    stream : rerun.RecordingStream
    scene : Scene
    """

    def __init__(self, rr: Any, stream: Any, scene: Scene) -> None:
        self._rr, self._stream, self._scene = rr, stream, scene
        self._size = scene_size(scene.episodes)
        self._metres_per_newton = metres_per_newton(scene.episodes)
        self._index, self._offset = 0, 0.0

    def write(self) -> None:
        """Write the whole scene."""
        self._static()
        end = -GAP_S
        for index, episode in enumerate(self._scene.episodes):
            first, last = episode.span
            begin = 0.0 if index == 0 else math.ceil(end + GAP_S)
            self._index, self._offset, end = index, begin - first, begin + last - first
            self._episode(episode)

    def _static(self) -> None:
        rr, newtons = self._rr, 1.0 / self._metres_per_newton
        legend = f"An arrow of 1 m is a force of {newtons:.3g} N. trundle {__version__}."
        text = rr.TextDocument(f"{self._scene.summary}\n\n{legend}", media_type="text/markdown")
        self._stream.log(SUMMARY, text, static=True)
        self._stream.log("/scene", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        styled = {key: style for each in self._scene.episodes for key, style in curve_styles(each).items()}
        for path, (name, colour) in styled.items():
            self._stream.log(path, rr.SeriesLines(colors=[colour], names=[name], widths=[1.5]), static=True)
        for key, role in (("contact", "recorded"), ("mismatch", "before"), ("residual", "after")):
            states = rr.StateConfiguration(
                values=[key, ""], colors=[COLOURS[role], (0, 0, 0)], visible=[True, False]
            )
            self._stream.log(f"/states/{key}", states, static=True)

    def _episode(self, episode: Episode) -> None:
        start, end = episode.span
        self._at(start)
        if self._index:
            for path in ("/scene", "/states"):
                self._stream.log(path, self._rr.Clear(recursive=True))
        self._object(episode)
        self._surroundings(episode)
        for name, arrow in episode.arrows.items():
            self._arrow(name, arrow)
        for panel in episode.panels:
            for curve in panel.curves:
                self._scalars(curve_path(panel.key, curve), curve.t, curve.values)
        for name, column in episode.table.items():
            seen = np.isfinite(column)
            self._scalars(f"/recording/{name}", episode.table["t"][seen], column[seen])
        self._states(
            "episode", [(start, f"{episode.name}{' (held out)' if episode.held_out else ''}"), (end, "")]
        )
        if start <= episode.contact <= end:
            self._states("contact", [(episode.contact, "contact"), (end, "")])
        for key, windows in episode.windows.items():
            self._states(key, list(window_states(key, windows)))

    def _object(self, episode: Episode) -> None:
        rr, shape = self._rr, episode.shape
        outline = object_outlines(shape)
        self._body("/scene/object", outline, shape.wheels, COLOURS["recorded"], 0.0)
        if len(shape.feet):
            feet = rr.Points3D(lift(shape.feet), radii=POINT_PIXELS, colors=[COLOURS["recorded"]])
            self._stream.log("/scene/object/feet", feet)
        if shape.points:
            points = rr.Points3D(
                lift(np.array(list(shape.points.values())), self._size * 0.02),
                radii=POINT_PIXELS,
                colors=[COLOURS["missing"]],
                labels=[name.replace("_", " ") for name in shape.points],
            )
            self._stream.log("/scene/object/points", points)
        self._motion("/scene/object", "recorded", episode.motion)
        for name, (motion, wheels) in episode.models.items():
            self._body(f"/scene/{name}", outline, wheels, COLOURS[name], -0.01)
            self._motion(f"/scene/{name}", name, motion)
        for time, wheel in episode.estimates:
            self._at(time)
            self._lines("/scene/object/estimate", [wheel_outline(wheel, self._size)], COLOURS["after"], 0.02)

    def _surroundings(self, episode: Episode) -> None:
        self._at(episode.span[0])
        if episode.obstacles:
            self._lines("/scene/obstacles", episode.obstacles, COLOURS["obstacle"], 0.0)
        if episode.goal is not None:
            self._lines("/scene/goal/outline", object_outlines(episode.shape), COLOURS["goal"], -0.02)
            self._stream.log("/scene/goal", self._transform(episode.goal))
        if episode.gripper is not None:
            arm = 0.08 * self._size
            cross = [np.array([[-arm, 0.0], [arm, 0.0]]), np.array([[0.0, -arm], [0.0, arm]])]
            self._lines("/scene/gripper/cross", cross, COLOURS["gripper"], 0.02)
            self._poses("/scene/gripper", episode.gripper)

    def _body(
        self, path: str, outline: Sequence[Floats], wheels: Sequence[Wheel], colour: Colour, height: float
    ) -> None:
        self._lines(f"{path}/outline", outline, colour, height)
        if wheels:
            self._lines(
                f"{path}/wheels", [wheel_outline(wheel, self._size) for wheel in wheels], colour, height
            )

    def _motion(self, path: str, source: str, motion: Motion) -> None:
        """Write poses over time, and the path of the origin as one line."""
        self._lines(f"/scene/paths/{source}", [motion.pose[:, :2]], COLOURS[source], -0.02)
        self._poses(path, motion)

    def _poses(self, path: str, motion: Motion) -> None:
        half = motion.pose[:, 2] / 2.0
        zero = np.zeros(len(half))
        columns = self._rr.Transform3D.columns(
            translation=lift(motion.pose[:, :2]),
            quaternion=np.column_stack([zero, zero, np.sin(half), np.cos(half)]),
        )
        self._columns(path, motion.t, columns)

    def _transform(self, pose: Floats) -> Any:
        turn = self._rr.RotationAxisAngle(axis=[0, 0, 1], radians=float(pose[2]))
        return self._rr.Transform3D(translation=[*pose[:2], 0.0], rotation=turn)

    def _arrow(self, name: str, arrow: Arrow) -> None:
        colour = COLOURS["recorded" if name == "measured" else "missing"]
        path = "/scene/object/measured" if name == "measured" else f"/scene/object/missing/{name}"
        style = self._rr.Arrows3D.from_fields(colors=[colour], radii=ARROW_PIXELS)
        self._stream.log(path, style, static=True)
        height = self._size * (0.03 if name == "measured" else 0.04)
        columns = self._rr.Arrows3D.columns(
            origins=lift(arrow.point, height), vectors=lift(arrow.wrench[:, :2] * self._metres_per_newton)
        )
        self._columns(path, arrow.t, columns)

    def _lines(self, path: str, lines: Sequence[Floats], colour: Colour, height: float) -> None:
        strips = [lift(line, height * self._size) for line in lines]
        self._stream.log(path, self._rr.LineStrips3D(strips, colors=[colour], radii=LINE_PIXELS))

    def _scalars(self, path: str, t: Floats, values: Floats) -> None:
        if len(t):
            self._columns(path, t, self._rr.Scalars.columns(scalars=values))

    def _states(self, key: str, states: Sequence[tuple[float, str]]) -> None:
        times, names = zip(*states, strict=True)
        self._columns(f"/states/{key}", np.array(times), self._rr.StateChange.columns(state=list(names)))

    def _columns(self, path: str, t: Floats, columns: Any) -> None:
        if len(t):
            times = self._rr.TimeColumn(TIME, duration=t + self._offset)
            indices = self._rr.TimeColumn(EPISODE, sequence=np.full(len(t), self._index))
            self._stream.send_columns(path, [times, indices], columns)

    def _at(self, t: float) -> None:
        self._stream.set_time(TIME, duration=t + self._offset)
        self._stream.set_time(EPISODE, sequence=self._index)


def window_states(key: str, windows: Sequence[Window]) -> Iterator[tuple[float, str]]:
    """Yield the starts and ends of windows, in the order of time."""
    for window in sorted(windows, key=lambda each: each.start):
        yield window.start, key
        yield window.end, ""
