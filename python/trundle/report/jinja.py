"""The Jinja environment of all pages: values are escaped, and an undefined value is an error."""

from __future__ import annotations

import base64
import hashlib
import re
from functools import cache

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

__all__ = ["render_template"]

_FORBIDDEN = re.compile("[\\x00-\\x08\\x0b-\\x1f\\x7f-\\x9f\\ud800-\\udfff]")
"""Control characters that HTML forbids."""
_SCRIPT_HASH = "sha256-of-the-script"
"""Stands for the hash in the page's security policy until the script is rendered."""


def render_template(package: str, template: str, **data: object) -> str:
    """Render a page.

    Parameters
    ----------
    package
        Python package whose folder `templates` holds the page's template. The templates of `trundle.report`,
        with the base template, the style sheet and the macros, are available to every page.
    template
        File name of the template.
    data
        Its variables.

    Returns
    -------
    str
        The page. Control characters that HTML forbids are replaced. Its security policy allows no request
        and no script but its own.
    """
    rendered = _environment(package).get_template(template).render(script_hash=_SCRIPT_HASH, **data)
    page = _FORBIDDEN.sub("\N{REPLACEMENT CHARACTER}", rendered)
    script = page.rpartition("<script>")[2].partition("</script>")[0]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return page.replace(_SCRIPT_HASH, f"sha256-{digest}", 1)


@cache
def _environment(package: str) -> Environment:
    packages = dict.fromkeys((package, "trundle.report"))
    return Environment(
        loader=ChoiceLoader([PackageLoader(name) for name in packages]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
