"""Pieces of Markdown."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

_WIDTH = 120


def join(*parts: str) -> str:
    """Return blocks, one after the other."""
    return "\n\n".join(parts)


def paragraph(text: str) -> str:
    """Return running text in lines of the page's width."""
    return _filled(text, "", "")


def bullets(*texts: str) -> str:
    """Return a list."""
    return "\n".join(_filled(text, "- ", "  ") for text in texts)


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _filled(text: str, first: str, later: str) -> str:
    return textwrap.fill(
        " ".join(text.split()),
        _WIDTH,
        initial_indent=first,
        subsequent_indent=later,
        break_long_words=False,
        break_on_hyphens=False,
    )
