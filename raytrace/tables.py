"""Results for people and programs: tables of two columns as text and as HTML, and plain types for JSON."""

from html import escape
from math import isfinite
from typing import Any

__all__ = ["html_table", "plain", "text_table"]


def text_table(rows: list[tuple[str, str]]) -> str:
    """The rows as lines, the second column under itself."""
    width = max(len(what) for what, _ in rows)
    return "\n".join(f"{what:{width}}  {value}" for what, value in rows)


def html_table(rows: list[tuple[str, str]]) -> str:
    """The rows as an HTML table, as Jupyter shows it."""
    cells = (f"<tr><th>{escape(what)}</th><td>{escape(value)}</td></tr>" for what, value in rows)
    return f"<table>{''.join(cells)}</table>"


def plain(value: Any) -> Any:
    """Return a value as plain types that strict JSON holds: a named tuple as a dict; what is not finite as a text."""
    if hasattr(value, "_asdict"):
        return {name: plain(part) for name, part in value._asdict().items()}
    if isinstance(value, dict):
        return {name: plain(part) for name, part in value.items()}
    if isinstance(value, tuple):
        return [plain(part) for part in value]
    if isinstance(value, float) and not isfinite(value):
        return str(value)
    return value
