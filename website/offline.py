"""Resources of pages on other hosts: the site must work without a network."""

from __future__ import annotations

import re

__all__ = ["remote_resources", "without_remote_scripts"]

SCRIPT = re.compile(r"<script\b.*?</script>", re.DOTALL)
IMPORT = re.compile(r"""(?:\bsrc=|\bfrom\s+|\bimport\s*\(?\s*)["']?(https?://[^"'\s>]+)""")
ELEMENT = re.compile(r"""<(?:img|iframe|source|link)\b[^>]*?\b(?:src|href)=["']?(https?://[^"'\s>]+)[^>]*>""")
REFERENCE = re.compile(r"""\brel=["']?(?:canonical|next|prev|edit)\b""")
"""Relations of links that load nothing."""


def remote_resources(page: str) -> list[str]:
    """Return the addresses on other hosts from which a page loads scripts, styles, pictures or frames."""
    scripts = [url for script in SCRIPT.findall(page) for url in IMPORT.findall(script)]
    elements = [found[1] for found in ELEMENT.finditer(page) if not REFERENCE.search(found[0])]
    return scripts + elements


def without_remote_scripts(page: str) -> str:
    """Return a page without the scripts that load something from another host."""
    return SCRIPT.sub(lambda found: "" if IMPORT.search(found[0]) else found[0], page)
