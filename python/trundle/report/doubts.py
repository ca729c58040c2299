"""What it might be instead: ties with their certificate, rivals, and the push that would tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from trundle.report import words
from trundle.report.figures import push
from trundle.report.given import Series
from trundle.report.markup import Child, Html, tag
from trundle.report.section import fold, section

__all__ = ["doubts"]

_NEAR = 0.01
"""Probability from which a rival is shown and not folded away."""


def doubts(diagnosis: Mapping[str, Any], given: Mapping[str, Any], series: Series) -> Html | None:
    """Return what the data cannot tell apart, and what they nearly cannot; None where nothing was near."""
    evidence = _Evidence.of(diagnosis, given, series)
    sets = [entry for entry in diagnosis.get("tied_sets") or () if len(entry) > 1]
    groups = [tuple(map(str, group)) for group in diagnosis.get("tied") or () if len(group) > 1]
    tied = {name for group in groups for name in group}
    in_sets = {_combined(" + ".join(map(str, group))) for entry in sets for group in entry}
    others = [
        entry
        for entry in evidence.rivals
        if str(entry.get("effect")) not in tied and _combined(entry.get("effect")) not in in_sets
    ]
    near = [entry for entry in others if (words.probability(entry) or 0.0) >= _NEAR]
    far = [entry for entry in others if entry not in near]
    if not groups and not others and not sets:
        return None
    cards = [_tie(index, group, evidence) for index, group in enumerate(groups)]
    cards += [_tied_sets(entry, evidence) for entry in sets]
    cards += [_rival(index, entry, evidence) for index, entry in enumerate(near, len(groups))]
    alone = "No other explanation that was tried comes near."
    if diagnosis.get("verdict") == "unexplained":
        alone = "No explanation that was tried is good enough; these pushes test the nearest ones."
    return section(
        "doubts",
        "What it might be instead",
        tag("div", cards, class_="cards") if cards else tag("p", alone),
        fold("Excluded, and how to check", tag("ul", [_excluded(entry) for entry in far])) if far else None,
    )


@dataclass(frozen=True)
class _Evidence:
    """What is known of pairs of explanations: rivals, certificates, experiments, and what was named."""

    named: frozenset[str]
    rivals: Sequence[Mapping[str, Any]]
    certificates: Sequence[Mapping[str, Any]]
    experiments: Sequence[Mapping[str, Any]]
    series: Series

    @classmethod
    def of(cls, diagnosis: Mapping[str, Any], given: Mapping[str, Any], series: Series) -> _Evidence:
        """Evidence from the answer and the curves beside it."""
        missing = diagnosis.get("missing") or ()
        return cls(
            frozenset(str(effect.get("effect")) for effect in missing),
            [entry for entry in diagnosis.get("alternatives") or () if isinstance(entry, Mapping)],
            [entry for entry in given.get("certificates") or () if isinstance(entry, Mapping)],
            [entry for entry in given.get("experiments") or () if isinstance(entry, Mapping)],
            series,
        )

    def within(self, entries: Sequence[Mapping[str, Any]], names: frozenset[str]) -> list[Mapping[str, Any]]:
        """Return the entries that compare two models of a set."""
        models = [{str(name) for name in entry.get("models") or ()} for entry in entries]
        return [entry for entry, pair in zip(entries, models, strict=True) if len(pair) > 1 and pair <= names]


def _tie(index: int, group: Sequence[str], evidence: _Evidence) -> Html:
    names = frozenset(group)
    certificates = evidence.within(evidence.certificates, names)
    planned = evidence.within(evidence.experiments, names)
    rivals = [entry.get("experiment") for entry in evidence.rivals if str(entry.get("effect")) in names]
    told: list[object] = [*planned] or [text for text in rivals if text] or [None]
    return tag(
        "article",
        tag("h3", words.capitalised(words.effects(group, "or")), tag("span", "tied", class_="kind")),
        tag("p", "This recording cannot tell them apart: any of them would do."),
        [_certificate(entry) for entry in certificates],
        [_experiment(f"{index}-{rank}", each, evidence.series) for rank, each in enumerate(told)],
        class_="doubt",
    )


def _tied_sets(sets: Sequence[Sequence[Any]], evidence: _Evidence) -> Html:
    """Return a class of whole sets of effects, with the certificates and pushes that compare them."""
    names = frozenset(_combined(" + ".join(map(str, group))) for group in sets)
    single = frozenset(str(name) for group in sets for name in group)
    known = [*evidence.within(evidence.certificates, names | single)]
    told = [each.get("experiment") for each in evidence.rivals if _combined(each.get("effect")) in names]
    return tag(
        "article",
        tag("h3", words.capitalised(words.sets(sets)), tag("span", "tied sets", class_="kind")),
        tag("p", "This recording cannot tell these sets of effects apart: any of them would do."),
        [_certificate(entry) for entry in known],
        [_experiment(f"sets-{rank}", text, evidence.series) for rank, text in enumerate(told or [None])],
        class_="doubt",
    )


def _combined(effect: object) -> str:
    """Return the name of a set of effects with its members in alphabetical order."""
    return " + ".join(sorted(part.strip() for part in str(effect).split("+")))


def _certificate(entry: Mapping[str, Any]) -> Html | None:
    text = entry.get("statement")
    return tag("p", tag("b", "Certificate: "), words.spoken(text)) if text else None


def _rival(index: int, entry: Mapping[str, Any], evidence: _Evidence) -> Html:
    share, name = words.probability(entry), str(entry.get("effect"))
    planned = evidence.within(evidence.experiments, evidence.named | {name})
    about = [found for found in planned if name in map(str, found.get("models") or ())]
    kind = None if share is None else tag("span", words.percent(share), class_="kind")
    told = about[0] if about else entry.get("experiment")
    return tag(
        "article",
        tag("h3", words.capitalised(words.effect(name)), kind),
        _experiment(str(index), told, evidence.series),
        class_="doubt",
    )


def _experiment(identity: str, given: object, series: Series) -> Child:
    """Return the push that would tell: a sentence, or an experiment whose pushes can be drawn."""
    if not given:
        return tag("p", "No push is known that would tell.")
    if not isinstance(given, Mapping):
        return tag("p", tag("b", "To tell: "), _ended(words.spoken(given)))
    pushes = [each for each in given.get("pushes") or () if isinstance(each, Mapping)]
    drawn = [
        push.draw(f"{identity}-{index}", index + 1 if len(pushes) > 1 else None, each, series)
        for index, each in enumerate(pushes)
    ]
    sentence = words.spoken(given.get("sentence") or "push as drawn.")
    panels = tag("div", drawn, class_="panels") if any(drawn) else None
    return [tag("p", tag("b", "To tell: "), sentence), panels]


def _ended(text: str) -> str:
    return text if text.endswith((".", "!", "?")) else f"{text}."


def _excluded(entry: Mapping[str, Any]) -> Html:
    share = words.probability(entry)
    odds = "" if share is None else f" ({words.percent(share)})"
    text = words.spoken(entry.get("experiment") or "no push is known that would tell")
    return tag(
        "li", tag("b", words.capitalised(words.effect(entry.get("effect")))), f"{odds}: ", _ended(text)
    )
