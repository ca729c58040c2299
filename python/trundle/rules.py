"""Conditions on settings, declared in the types of the fields of a dataclass."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

__all__ = ["Count", "EnvOptions", "Natural", "Positive", "Rule", "Share", "pattern"]


@dataclass(frozen=True)
class Rule:
    """A condition on a value, for `Annotated`.

    Attributes
    ----------
    holds : callable
        Returns whether a value of the right type is allowed.
    words : str
        The allowed values, for the message: "a number from 0 to 1".
    """

    holds: Callable[[Any], bool]
    words: str


def pattern(expression: str, words: str) -> Rule:
    """Return the rule that a string matches a regular expression."""
    return Rule(lambda text: re.fullmatch(expression, text) is not None, words)


Count = Annotated[int, Rule(lambda value: value >= 1, "a whole number of at least 1")]
Natural = Annotated[int, Rule(lambda value: value >= 0, "a whole number of at least 0")]
Share = Annotated[float, Rule(lambda value: 0 <= value <= 1, "a number from 0 to 1")]
Positive = Annotated[float, Rule(lambda value: value > 0, "a number above 0")]
EnvOptions = Annotated[
    dict[str, Any],
    Rule(lambda value: value.get("horizon") != 0, "a table in which horizon is not 0: an episode must end"),
]
"""Arguments of an environment whose episodes end."""
