"""Figure of a diagnosis: where the missing effects act, how probable they are, and what they change."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from trundle.plots.agreement import draw_agreement
from trundle.plots.evidence import draw_evidence
from trundle.plots.maps import draw_floor, draw_object, has_floor_marks, has_object_marks
from trundle.plots.motion import MotionPanels, simulated
from trundle.plots.style import heading, on_figure
from trundle.report import wording
from trundle.report.figures.motion import events_in
from trundle.report.location import locate_effects
from trundle.report.series import Series, held_out_first
from trundle.report.verdict import headline, improvement_sentence, is_single

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

    from trundle.diagnosis import Diagnosis

__all__ = ["diagnosis"]

MAX_EPISODES = 3
"""Maximum number of episodes whose motion is drawn."""
_WIDTH, _MAP, _BARS = 11.0, 3.9, 1.9
_MOTION, _RAIL, _AGREEMENT = 5.2, 3.2, 3.6
"""Heights of the parts, inches."""

Panel: TypeAlias = "Callable[[Axes], None]"


def diagnosis(diagnosis: Diagnosis, *, figure: Figure | SubFigure | None = None) -> Figure:
    """Draw a diagnosis: maps with the missing effects, probabilities, and held-out episodes before and after.

    Parameters
    ----------
    diagnosis : Diagnosis
        Result of `trundle.diagnose`.
    figure : Figure or SubFigure, optional
        Where to draw; by default a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        In the first row: the object from above, the floor if an effect is located on it, and probabilities of
        explanations (for "unexplained" the misfit by axis, for "reparameterised" the changes of values). In
        the second: recorded and simulated motion of up to three episodes, held-out ones first; for
        quasi-static pushes, the required and the recorded wrench.

    Raises
    ------
    TrundleError
        If matplotlib is missing.

    Examples
    --------
    >>> import trundle
    >>> found = trundle.diagnose("recordings/run_3")  # doctest: +SKIP
    >>> trundle.plots.diagnosis(found).savefig("diagnosis.png")  # doctest: +SKIP
    """
    answer = diagnosis.answer
    series = Series.parse(diagnosis.series, single=is_single(answer, diagnosis.series.get("unnamed")))
    panels = _panels(answer, diagnosis.series, series)
    below = _below(answer, series)
    heights = [_MAP if len(panels) > 1 else _BARS, *([below[0]] if below else [])]
    on, whole = on_figure(figure, (_WIDTH, sum(heights) + 0.9))
    parts = on.add_gridspec(len(heights), 1, height_ratios=heights)
    top = parts[0].subgridspec(1, len(panels))
    for column, draw in enumerate(panels):
        draw(on.add_subplot(top[column]))
    if below:
        below[1](on, parts[1])
    title = wording.typeset(headline(answer))
    heading(on, f"{answer.get('recording')}: {title}", *_sentences(answer, series))
    return whole


def _sentences(answer: Mapping[str, Any], series: Series) -> list[str]:
    statements = [str(effect.get("statement") or "") for effect in answer.get("missing") or ()]
    return [*(wording.typeset(text) for text in statements), improvement_sentence(answer, series)]


def _panels(answer: Mapping[str, Any], given: Mapping[str, Any], series: Series) -> list[Panel]:
    """Return what the first row consists of."""
    found: list[Panel] = []
    on_floor = has_floor_marks(answer, series)
    if series.footprint and (has_object_marks(answer) or not on_floor):
        found.append(lambda axes: draw_object(axes, answer, series))
    if on_floor:
        found.append(lambda axes: draw_floor(axes, answer, series))
    return [*found, lambda axes: draw_evidence(axes, answer, given.get("candidates") or (), series)]


def _below(answer: Mapping[str, Any], series: Series) -> tuple[float, Callable[[Any, Any], None]] | None:
    """Return height, inches, and drawing of the second row; None without simulations."""
    named = locate_effects(answer.get("missing") or ())
    moving = [each for each in held_out_first(series.episodes) if len(each.t) > 1 and simulated(each)]
    if moving:
        chosen = sorted(moving, key=lambda each: not events_in(each, named))[:MAX_EPISODES]
        single = all(each.before is None for each in chosen)
        names = {"before": "before", "after": "simulation" if single else "after"}
        motion = MotionPanels(chosen, series, names, named)

        def draw(on: Any, cell: Any) -> None:
            grid = cell.subgridspec(1, len(chosen))
            motion.draw(on, [grid[index] for index in range(len(chosen))])

        return (_RAIL if motion.on_rail else _MOTION), draw
    compared: Sequence[Any] = [each for each in series.episodes if each.wrench is not None]
    return (_AGREEMENT, lambda on, cell: draw_agreement(on, cell, series)) if compared else None
