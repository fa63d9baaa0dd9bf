"""Markdown tables, printed as they grow."""

from __future__ import annotations

from collections.abc import Sequence


def head(title: str, *columns: str, note: str = "") -> None:
    """Title, note and column names; those that begin with ">" are numbers."""
    print(f"\n### {title}\n")
    if note:
        print(f"{note}\n")
    row(*(c.lstrip(">") for c in columns))
    row(*("---:" if c.startswith(">") else "---" for c in columns))


def row(*cells: object) -> None:
    print("|" + "|".join(f" {shown(c)} " for c in cells) + "|", flush=True)


def shown(cell: object) -> str:
    if cell is None:
        return "–"
    if isinstance(cell, float):
        return f"{cell:.3g}" if cell < 1000 else grouped(round(cell))
    return grouped(cell) if isinstance(cell, int) else str(cell)


def grouped(number: int) -> str:
    return f"{number:,}".replace(",", " ")


def megabytes(n_bytes: int) -> float:
    return n_bytes / 1e6


def listed(words: Sequence[str]) -> str:
    return ", ".join(words) or "none"
