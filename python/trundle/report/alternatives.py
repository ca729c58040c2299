"""Data of the section "Alternative explanations": ties, competing effects, and discriminating pushes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from trundle.report import wording
from trundle.report.figures import push
from trundle.report.series import Series

__all__ = ["alternatives"]

Card = dict[str, Any]

_MIN_SHOWN_PROBABILITY = 0.01
"""An alternative with at least this probability has a card; the others are collapsed."""


def alternatives(diagnosis: Mapping[str, Any], given: Mapping[str, Any], series: Series) -> Card | None:
    """Return cards of indistinguishable and competing explanations; None if there are none.

    Parameters
    ----------
    diagnosis
        The content of diagnosis.json.
    given
        The series of the report as dictionaries, for `certificates` and `experiments`.
    series
        The same series, parsed.
    """
    evidence = _Evidence.from_diagnosis(diagnosis, given, series)
    sets = [entry for entry in diagnosis.get("tied_sets") or () if len(entry) > 1]
    groups = [tuple(map(str, group)) for group in diagnosis.get("tied") or () if len(group) > 1]
    tied = {name for group in groups for name in group}
    in_sets = {_sorted_set_name(" + ".join(map(str, group))) for entry in sets for group in entry}
    others = [
        entry
        for entry in evidence.alternatives
        if str(entry.get("effect")) not in tied and _sorted_set_name(entry.get("effect")) not in in_sets
    ]
    near = [entry for entry in others if (wording.probability_of(entry) or 0.0) >= _MIN_SHOWN_PROBABILITY]
    far = [entry for entry in others if entry not in near]
    if not groups and not others and not sets:
        return None
    cards = [_tie_card(index, group, evidence) for index, group in enumerate(groups)]
    cards += [_tied_sets_card(entry, evidence) for entry in sets]
    cards += [_alternative_card(index, entry, evidence) for index, entry in enumerate(near, len(groups))]
    return {"cards": cards, "excluded": [_excluded(entry) for entry in far]}


@dataclass(frozen=True)
class _Evidence:
    """Evidence on pairs of explanations.

    Attributes
    ----------
    named
        Effects that the diagnosis names.
    alternatives, certificates, experiments
        Entries of the diagnosis and of the series.
    series
        For the drawings of pushes.
    """

    named: frozenset[str]
    alternatives: Sequence[Mapping[str, Any]]
    certificates: Sequence[Mapping[str, Any]]
    experiments: Sequence[Mapping[str, Any]]
    series: Series

    @classmethod
    def from_diagnosis(
        cls, diagnosis: Mapping[str, Any], given: Mapping[str, Any], series: Series
    ) -> _Evidence:
        """Return the evidence in a diagnosis and its series."""
        missing = diagnosis.get("missing") or ()
        return cls(
            frozenset(str(effect.get("effect")) for effect in missing),
            [entry for entry in diagnosis.get("alternatives") or () if isinstance(entry, Mapping)],
            [entry for entry in given.get("certificates") or () if isinstance(entry, Mapping)],
            [entry for entry in given.get("experiments") or () if isinstance(entry, Mapping)],
            series,
        )

    def comparing(
        self, entries: Sequence[Mapping[str, Any]], names: frozenset[str]
    ) -> list[Mapping[str, Any]]:
        """Return the entries that compare two of the named models."""
        models = [{str(name) for name in entry.get("models") or ()} for entry in entries]
        return [entry for entry, pair in zip(entries, models, strict=True) if len(pair) > 1 and pair <= names]


def _tie_card(index: int, group: Sequence[str], evidence: _Evidence) -> Card:
    names = frozenset(group)
    planned = evidence.comparing(evidence.experiments, names)
    texts = [entry.get("experiment") for entry in evidence.alternatives if str(entry.get("effect")) in names]
    experiments: list[object] = [*planned] or [text for text in texts if text] or [None]
    return {
        "title": wording.capitalise(wording.effect_names(group, "or")),
        "kind": "tied",
        "tied": "effects",
        "certificates": _certificates(names, evidence),
        "experiments": [
            _experiment(f"{index}-{rank}", each, evidence.series) for rank, each in enumerate(experiments)
        ],
    }


def _tied_sets_card(sets: Sequence[Sequence[Any]], evidence: _Evidence) -> Card:
    """Return the card of tied sets of effects, with the certificates and pushes that compare them."""
    names = frozenset(_sorted_set_name(" + ".join(map(str, group))) for group in sets)
    single = frozenset(str(name) for group in sets for name in group)
    experiments = [
        each.get("experiment")
        for each in evidence.alternatives
        if _sorted_set_name(each.get("effect")) in names
    ]
    return {
        "title": wording.capitalise(wording.effect_sets(sets)),
        "kind": "tied sets",
        "tied": "sets of effects",
        "certificates": _certificates(names | single, evidence),
        "experiments": [
            _experiment(f"sets-{rank}", text, evidence.series)
            for rank, text in enumerate(experiments or [None])
        ],
    }


def _sorted_set_name(effect: object) -> str:
    """Return the name of a set of effects with its members in alphabetical order."""
    return " + ".join(sorted(part.strip() for part in str(effect).split("+")))


def _certificates(names: frozenset[str], evidence: _Evidence) -> list[str]:
    found = evidence.comparing(evidence.certificates, names)
    return [wording.typeset(entry["statement"]) for entry in found if entry.get("statement")]


def _alternative_card(index: int, entry: Mapping[str, Any], evidence: _Evidence) -> Card:
    name = str(entry.get("effect"))
    planned = evidence.comparing(evidence.experiments, evidence.named | {name})
    relevant = [found for found in planned if name in map(str, found.get("models") or ())]
    experiment = relevant[0] if relevant else entry.get("experiment")
    return {
        "title": wording.capitalise(wording.effect_name(name)),
        "kind": wording.format_share(entry.get("probability")),
        "tied": "",
        "certificates": [],
        "experiments": [_experiment(str(index), experiment, evidence.series)],
    }


def _experiment(identity: str, given: object, series: Series) -> Card | None:
    """Return a discriminating experiment, given as a sentence or as a table whose pushes are drawn."""
    if not given:
        return None
    if not isinstance(given, Mapping):
        return {"sentence": _with_full_stop(wording.typeset(given)), "figures": []}
    pushes = [each for each in given.get("pushes") or () if isinstance(each, Mapping)]
    drawn = [
        push.draw(f"{identity}-{index}", index + 1 if len(pushes) > 1 else None, each, series)
        for index, each in enumerate(pushes)
    ]
    return {
        "sentence": wording.typeset(given.get("sentence") or "push as drawn."),
        "figures": [figure for figure in drawn if figure is not None],
    }


def _with_full_stop(text: str) -> str:
    return text if text.endswith((".", "!", "?")) else f"{text}."


def _excluded(entry: Mapping[str, Any]) -> Card:
    return {
        "name": wording.capitalise(wording.effect_name(entry.get("effect"))),
        "probability": wording.format_share(entry.get("probability")),
        "experiment": _with_full_stop(
            wording.typeset(entry.get("experiment") or "no push is known that tests it")
        ),
    }
