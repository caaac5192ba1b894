"""Tables of two columns, what and how much, as text and as HTML."""

from html import escape

__all__ = ["html_table", "text_table"]


def text_table(rows: list[tuple[str, str]]) -> str:
    """The rows as lines, the second column under itself."""
    width = max(len(what) for what, _ in rows)
    return "\n".join(f"{what:{width}}  {value}" for what, value in rows)


def html_table(rows: list[tuple[str, str]]) -> str:
    """The rows as an HTML table, as Jupyter shows it."""
    cells = (f"<tr><th>{escape(what)}</th><td>{escape(value)}</td></tr>" for what, value in rows)
    return f"<table>{''.join(cells)}</table>"
