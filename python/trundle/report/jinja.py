"""The Jinja environment of all pages: values are escaped, and an undefined value is an error."""

from __future__ import annotations

import re
from functools import cache

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

__all__ = ["render_template"]

_FORBIDDEN = re.compile("[\\x00-\\x08\\x0b-\\x1f\\x7f-\\x9f\\ud800-\\udfff]")
"""Control characters that HTML forbids."""


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
        The page. Control characters that HTML forbids are replaced.
    """
    page = _environment(package).get_template(template).render(**data)
    return _FORBIDDEN.sub("\N{REPLACEMENT CHARACTER}", page)


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
