"""Settings files: TOML parsed into dataclasses; unknown keys and wrong types or values are errors.

pydantic, cattrs and msgspec accept unknown keys, accept 2.5 as an integer, or do not name value and remedy.
"""

from __future__ import annotations

import dataclasses
import difflib
import sys
import types
import typing
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

from trundle._native import TrundleError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = [
    "SettingsError",
    "build_settings",
    "check_horizon",
    "parse",
    "parse_format",
    "read_settings",
    "typed",
]

T = TypeVar("T")


class SettingsError(ValueError):
    """An invalid setting; the message names the key and the expected value.

    Examples
    --------
    >>> from trundle import importers
    >>> try:
    ...     raise importers.MapError("time.column: must be text, not 3")
    ... except ValueError as error:
    ...     print(error)
    time.column: must be text, not 3
    """


def parse(path: Path, remedy: str = "") -> dict[str, Any]:
    """Parse a TOML file; the error for an absent file ends with `remedy`."""
    try:
        with path.open("rb") as file:
            return tomllib.load(file)
    except FileNotFoundError as error:
        raise TrundleError(
            f"{path}: no such file; the files of trundle are in configs/ of its repository{remedy}"
        ) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise TrundleError(f"{path}: not a TOML file: {error}") from error


def parse_format(path: Path, form: str, remedy: str = "") -> dict[str, Any]:
    """Parse a TOML file that must contain `format = "form"`; return the other keys."""
    found = parse(path, remedy)
    if found.pop("format", None) != form:
        raise TrundleError(f'{path}: must begin with format = "{form}"')
    return found


def read_settings(path: Path, form: str, kind: type[T]) -> T:
    """Read the dataclass `kind` from a TOML file that contains `format = "form"`.

    Raises
    ------
    TrundleError
        If a key is missing, unknown or of another type, or a value is not allowed.
    """
    return build_settings(path, kind, parse_format(path, form))


def build_settings(path: Path, kind: type[T], table: Mapping[str, Any]) -> T:
    """Build a dataclass as `typed` does; an error is a `TrundleError` that also names the file."""
    try:
        return typed(kind, table)
    except SettingsError as error:
        raise TrundleError(f"{path}: {error}") from error


def check_horizon(path: Path, arguments: Mapping[str, Any], where: str) -> None:
    """Refuse arguments of an environment for which an episode never ends."""
    if arguments.get("horizon", 1) == 0:
        raise TrundleError(f"{path}: [{where}] horizon = 0: an episode must end; give a number of steps")


def typed(kind: type[T], table: Mapping[str, Any], where: str = "") -> T:
    """Build the dataclass `kind` from a parsed table.

    Parameters
    ----------
    kind : type
        A dataclass. Fields may be numbers, strings, booleans, `Literal`, lists, tuples, dictionaries with
        string keys, optional values, and dataclasses. `dict[str, Any]` accepts any table. `Annotated` adds a
        rule of `trundle.rules`. `__post_init__` may raise `SettingsError` for contradictory fields.
    table : mapping
        The parsed TOML table.
    where : str
        Key of the table, for messages: "topic.object".

    Returns
    -------
    kind
        The settings, with defaults for absent keys.
    """
    hints = typing.get_type_hints(kind, include_extras=True)
    fields = {field.name: field for field in dataclasses.fields(typing.cast("Any", kind))}
    for key in table:
        if key not in fields:
            raise SettingsError(f"unknown key `{_join(where, key)}`{_nearest(key, fields)}")
    missing = [name for name, field in fields.items() if name not in table and _required(field)]
    if missing:
        raise SettingsError(f"`{_join(where, missing[0])}` is missing{_expected(hints[missing[0]])}")
    values = {key: _value(hints[key], value, _join(where, key)) for key, value in table.items()}
    try:
        return kind(**values)
    except SettingsError as error:
        raise SettingsError(f"[{where}] {error}" if where else str(error)) from error


def _value(hint: Any, value: Any, where: str) -> Any:
    if hint is Any:
        return value
    origin = get_origin(hint)
    if origin is Annotated:
        of, rule = get_args(hint)
        found = _value(of, value, where)
        if not rule.holds(found):
            raise SettingsError(f"`{where}` = {value!r}{_expected(hint)}")
        return found
    if origin in (Union, types.UnionType):
        return _union(hint, value, where)
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return typed(hint, _instance(dict, value, hint, where), where)
    if origin is typing.Literal:
        if value not in get_args(hint):
            raise SettingsError(f"`{where}` = {value!r}{_expected(hint)}")
        return value
    if origin is dict:
        key_kind, of = get_args(hint)
        table = _instance(dict, value, hint, where)
        return {
            _value(key_kind, key, where): _value(of, each, _join(where, key)) for key, each in table.items()
        }
    if origin in (list, tuple):
        return origin(_items(hint, _instance(list, value, hint, where), where))
    if hint is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    return _instance(hint, value, hint, where)


def _union(hint: Any, value: Any, where: str) -> Any:
    choices = [choice for choice in get_args(hint) if choice is not type(None)]
    if value is None and len(choices) < len(get_args(hint)):
        return None
    if len(choices) == 1:
        return _value(choices[0], value, where)
    for choice in choices:
        try:
            return _value(choice, value, where)
        except SettingsError as error:
            # The message of the dataclass is more specific than that of the union.
            if isinstance(value, dict) and dataclasses.is_dataclass(choice):
                raise error
    raise SettingsError(f"`{where}` = {value!r}{_expected(hint)}")


def _items(hint: Any, values: list[Any], where: str) -> Iterator[Any]:
    kinds = get_args(hint)
    if get_origin(hint) is list or kinds[1:] == (...,):
        kinds = kinds[:1] * len(values)
    if len(values) != len(kinds):
        raise SettingsError(f"`{where}` = {values!r} has {len(values)} entries; it needs {len(kinds)}")
    for i, (kind, each) in enumerate(zip(kinds, values, strict=True)):
        yield _value(kind, each, f"{where}[{i}]")


def _instance(kind: type[Any], value: Any, hint: Any, where: str) -> Any:
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise SettingsError(f"`{where}` = {value!r}{_expected(hint)}")
    return value


def _required(field: dataclasses.Field[Any]) -> bool:
    return field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING


def _expected(hint: Any) -> str:
    return f"; it is {_words(hint)}"


def _words(hint: Any) -> str:
    words = {float: "a number", int: "a whole number", str: "a string", bool: "true or false", list: "a list"}
    origin, arguments = get_origin(hint) or hint, get_args(hint)
    if origin is Annotated:
        return str(arguments[1].words)
    if origin in (Union, types.UnionType):
        return " or ".join(_words(choice) for choice in arguments if choice is not type(None))
    if origin is typing.Literal:
        return f"{'one of ' if arguments[1:] else ''}{', '.join(map(repr, arguments))}"
    if origin is dict or dataclasses.is_dataclass(origin):
        return "a table"
    if origin is tuple:
        return "a list" if arguments[1:] == (...,) else f"a list of {len(arguments)}"
    return words.get(origin, str(hint))


def _nearest(key: str, known: Mapping[str, Any]) -> str:
    near = difflib.get_close_matches(key, known, n=1)
    return (
        f"; did you mean `{near[0]}`?" if near else f"; known are {', '.join(f'`{name}`' for name in known)}"
    )


def _join(where: str, key: str) -> str:
    return f"{where}.{key}" if where else key
