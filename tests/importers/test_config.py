"""Maps: TOML into dataclasses, strictly."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import pytest

from trundle.importers.config import MapError, load, typed


@dataclass(frozen=True)
class Inner:
    gain: float
    label: str = "none"


@dataclass(frozen=True)
class Outer:
    inner: Inner
    kind: Literal["a", "b"] = "a"
    pair: tuple[float, float] = (0.0, 1.0)
    names: list[str] = field(default_factory=list)
    either: str | Inner | None = None
    count: int | None = None
    flag: bool = False
    rest: dict[str, Any] = field(default_factory=dict)


def test_valid_settings() -> None:
    table = {
        "inner": {"gain": 2},
        "kind": "b",
        "pair": [1, 2.5],
        "names": ["x"],
        "either": {"gain": 0.5},
        "count": 3,
        "flag": True,
        "rest": {"any": {"thing": [1]}},
    }
    assert typed(Outer, table) == Outer(
        Inner(2.0), "b", (1.0, 2.5), ["x"], Inner(0.5), 3, True, {"any": {"thing": [1]}}
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"flg": True}, "unknown key `flg`; did you mean `flag`?"),
        ({"zzz": 1}, "unknown key `zzz`; known are `inner`, `kind`"),
        ({"inner": {}}, "`inner.gain` is missing; it is a number"),
        ({"inner": 4}, "`inner` = 4; it is a table"),
        ({"inner": {"gain": "2"}}, "`inner.gain` = '2'; it is a number"),
        ({"inner": {"gain": True}}, "`inner.gain` = True; it is a number"),
        ({"kind": "c"}, "`kind` = 'c'; it is one of 'a', 'b'"),
        ({"pair": [1.0]}, r"`pair` = [1.0] has 1 entries; it needs 2"),
        ({"pair": ["1", 2]}, "`pair[0]` = '1'; it is a number"),
        ({"names": "x"}, "`names` = 'x'; it is a list"),
        ({"names": [1]}, "`names[0]` = 1; it is a string"),
        ({"either": 1}, "`either` = 1; it is a string or a table"),
        ({"either": {"gian": 1}}, "unknown key `either.gian`; did you mean `gain`?"),
        ({"count": 1.5}, "`count` = 1.5; it is a whole number"),
        ({"flag": 1}, "`flag` = 1; it is true or false"),
    ],
)
def test_invalid_settings(change: dict[str, Any], message: str) -> None:
    with pytest.raises(MapError) as raised:
        typed(Outer, {"inner": {"gain": 1.0}} | change)
    assert message in str(raised.value)


def test_invalid_toml_names_the_line(tmp_path: Path) -> None:
    path = tmp_path / "map.toml"
    path.write_text("a = 1\nb = \n")
    with pytest.raises(MapError, match=r"map\.toml: not a TOML file: .*line 2"):
        load(path)
