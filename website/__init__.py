"""The documentation site: hooks of mkdocs, and generators of its reference pages."""
