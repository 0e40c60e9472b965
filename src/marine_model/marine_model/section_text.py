"""A section as YAML text that reads back to the same section."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import yaml

from marine_model.schema import Section

_WIDTH = 120


def section_text(section: Section, remarks: str = "") -> str:
    """Return the fields of ``section`` that were set as a YAML document, below ``remarks`` as comment lines."""
    comment = "".join(f"# {line}".rstrip() + "\n" for line in remarks.splitlines())
    content = _plain(section.model_dump(exclude_unset=True))
    # Short lists and mappings on one line; field names such as "on" are quoted.
    return comment + yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=_WIDTH, allow_unicode=True)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        # Names and single numbers first, as people write them; else in the order of the section.
        whole = sorted(value.items(), key=lambda entry: isinstance(entry[1], Mapping | list | tuple))
        return {key: _plain(item) for key, item in whole}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value
