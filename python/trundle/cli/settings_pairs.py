"""Values of settings as arguments: `--set NAME=VALUE`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["add_set", "parse_pairs", "parse_value"]


def add_set(parser: argparse.ArgumentParser, help: str) -> None:
    """Add `--set NAME=VALUE`: `args.set`, a list of strings for `parse_pairs`."""
    parser.add_argument(
        "--set", metavar="NAME=VALUE", action="append", default=[], help=f"{help}; may be repeated"
    )


def parse_pairs(pairs: Sequence[str]) -> dict[str, Any]:
    """Parse NAME=VALUE pairs."""
    from trundle import TrundleError

    found = {}
    for pair in pairs:
        name, sign, text = pair.partition("=")
        if not sign or not name:
            raise TrundleError(f"--set {pair}: write NAME=VALUE")
        found[name] = parse_value(text)
    return found


def parse_value(text: str) -> Any:
    """Parse a value in TOML; any other text is a string."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
