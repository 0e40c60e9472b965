"""Pages as HTML text from the templates beside this module."""

from __future__ import annotations

from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape


def fill_in(template: str, **values: Any) -> str:
    """Return a page that refers to nothing outside itself; a value that the template asks for and lacks is an error."""
    environment = Environment(
        loader=PackageLoader("dp_tools.report"),
        autoescape=select_autoescape(default=True),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(**values)
