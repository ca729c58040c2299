"""Section "Alternative explanations": ties with certificates, competing effects, discriminating pushes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from trundle.report import wording
from trundle.report.figures import push
from trundle.report.markup import Child, Html, tag
from trundle.report.section import collapsible, section
from trundle.report.series import Series

__all__ = ["alternatives"]

_MIN_SHOWN_PROBABILITY = 0.01
"""An alternative with at least this probability has a card; the others are collapsed."""


def alternatives(diagnosis: Mapping[str, Any], given: Mapping[str, Any], series: Series) -> Html | None:
    """Return the section on indistinguishable and competing explanations; None if there are none.

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
    without_cards = "No other tested explanation is plausible."
    if diagnosis.get("verdict") == "unexplained":
        without_cards = "No tested explanation fits well enough. The pushes below test the closest ones."
    excluded = tag("ul", [_excluded_item(entry) for entry in far])
    return section(
        "alternatives",
        "Alternative explanations",
        tag("div", cards, class_="cards") if cards else tag("p", without_cards),
        collapsible("Excluded explanations, and how to test them", excluded) if far else None,
    )


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


def _tie_card(index: int, group: Sequence[str], evidence: _Evidence) -> Html:
    names = frozenset(group)
    certificates = evidence.comparing(evidence.certificates, names)
    planned = evidence.comparing(evidence.experiments, names)
    texts = [entry.get("experiment") for entry in evidence.alternatives if str(entry.get("effect")) in names]
    experiments: list[object] = [*planned] or [text for text in texts if text] or [None]
    return tag(
        "article",
        tag("h3", wording.capitalise(wording.effect_names(group, "or")), tag("span", "tied", class_="kind")),
        tag("p", "This recording cannot distinguish these effects: each explains it equally well."),
        [_certificate(entry) for entry in certificates],
        [_experiment(f"{index}-{rank}", each, evidence.series) for rank, each in enumerate(experiments)],
        class_="alternative",
    )


def _tied_sets_card(sets: Sequence[Sequence[Any]], evidence: _Evidence) -> Html:
    """Return the card of tied sets of effects, with the certificates and pushes that compare them."""
    names = frozenset(_sorted_set_name(" + ".join(map(str, group))) for group in sets)
    single = frozenset(str(name) for group in sets for name in group)
    certificates = evidence.comparing(evidence.certificates, names | single)
    experiments = [
        each.get("experiment")
        for each in evidence.alternatives
        if _sorted_set_name(each.get("effect")) in names
    ]
    return tag(
        "article",
        tag("h3", wording.capitalise(wording.effect_sets(sets)), tag("span", "tied sets", class_="kind")),
        tag("p", "This recording cannot distinguish these sets of effects: each explains it equally well."),
        [_certificate(entry) for entry in certificates],
        [
            _experiment(f"sets-{rank}", text, evidence.series)
            for rank, text in enumerate(experiments or [None])
        ],
        class_="alternative",
    )


def _sorted_set_name(effect: object) -> str:
    """Return the name of a set of effects with its members in alphabetical order."""
    return " + ".join(sorted(part.strip() for part in str(effect).split("+")))


def _certificate(entry: Mapping[str, Any]) -> Html | None:
    text = entry.get("statement")
    return tag("p", tag("b", "Certificate: "), wording.typeset(text)) if text else None


def _alternative_card(index: int, entry: Mapping[str, Any], evidence: _Evidence) -> Html:
    share, name = wording.probability_of(entry), str(entry.get("effect"))
    planned = evidence.comparing(evidence.experiments, evidence.named | {name})
    relevant = [found for found in planned if name in map(str, found.get("models") or ())]
    kind = None if share is None else tag("span", wording.format_percent(share), class_="kind")
    experiment = relevant[0] if relevant else entry.get("experiment")
    return tag(
        "article",
        tag("h3", wording.capitalise(wording.effect_name(name)), kind),
        _experiment(str(index), experiment, evidence.series),
        class_="alternative",
    )


def _experiment(identity: str, given: object, series: Series) -> Child:
    """Return a discriminating experiment, given as a sentence or as a table whose pushes are drawn."""
    if not given:
        return tag("p", "No push is known that distinguishes them.")
    if not isinstance(given, Mapping):
        return tag("p", tag("b", "To distinguish them: "), _with_full_stop(wording.typeset(given)))
    pushes = [each for each in given.get("pushes") or () if isinstance(each, Mapping)]
    drawn = [
        push.draw(f"{identity}-{index}", index + 1 if len(pushes) > 1 else None, each, series)
        for index, each in enumerate(pushes)
    ]
    sentence = wording.typeset(given.get("sentence") or "push as drawn.")
    panels = tag("div", drawn, class_="panels") if any(drawn) else None
    return [tag("p", tag("b", "To distinguish them: "), sentence), panels]


def _with_full_stop(text: str) -> str:
    return text if text.endswith((".", "!", "?")) else f"{text}."


def _excluded_item(entry: Mapping[str, Any]) -> Html:
    share = wording.probability_of(entry)
    odds = "" if share is None else f" ({wording.format_percent(share)})"
    text = wording.typeset(entry.get("experiment") or "no push is known that tests it")
    return tag(
        "li",
        tag("b", wording.capitalise(wording.effect_name(entry.get("effect")))),
        f"{odds}: ",
        _with_full_stop(text),
    )
