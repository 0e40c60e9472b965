"""What is found wrong with a bag."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """Something worth telling of a bag.

    Attributes
    ----------
    where
        File or topic.
    text
        What is wrong.
    wrong
        False for what may be as it should, but is worth knowing.
    """

    where: str
    text: str
    wrong: bool = True

    def __str__(self) -> str:
        return f"{self.where}: {self.text}"
