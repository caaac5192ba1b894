"""What a user sees on a terminal while something takes time."""

import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["Waits", "hide_waits", "progress", "show_waits"]


def _on_a_terminal() -> bool:
    return sys.stderr is not None and sys.stderr.isatty()


class Waits(logging.Handler):
    """Shows what the library logs of a wait (an attribute `waits` of the record) as long as it lasts.

    Within `progress` the bar's text says it, else there is a spinner.
    """

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self._tell: Callable[[str | None], object] | None = None
        #: What is on the terminal now, a bar or a spinner; `stop` takes it away, and shows the cursor again.
        self._shown: Any = None

    def emit(self, record: logging.LogRecord) -> None:
        """Begin to show a wait, or end it."""
        waits = getattr(record, "waits", None)
        if waits is None:
            return
        if self._tell is not None:
            self._tell(record.getMessage() if waits else None)
        elif waits:
            from rich.console import Console
            from rich.status import Status

            self._shown = Status(record.getMessage(), console=Console(stderr=True))
            self._shown.start()
        else:
            self.hide()

    def hide(self) -> None:
        """Take what is shown from the terminal."""
        shown, self._shown = self._shown, None
        if shown is not None:
            shown.stop()

    @contextmanager
    def told_to(self, bar: Any, tell: Callable[[str | None], object]) -> Iterator[None]:
        """Within this context a bar is shown, and `tell` is given the text of each wait, and ``None`` at its end."""
        self._shown, self._tell = bar, tell
        try:
            yield
        finally:
            self._shown = self._tell = None


_waits = Waits()


def show_waits() -> None:
    """Show from now on, on a terminal, what the library waits for."""
    if _on_a_terminal():
        log = logging.getLogger("raytrace")
        log.setLevel(logging.INFO)
        log.addHandler(_waits)


def hide_waits() -> None:
    """Take what is shown from the terminal, as the process ends."""
    _waits.hide()


@contextmanager
def progress(total: int, what: str = "rendering") -> Iterator:
    """Show progress on a terminal, nothing anywhere else; gives the function that advances it.

    Until something has advanced it only says that it works, and for how long: a bar at 0 % would say nothing.
    """
    if not _on_a_terminal():
        yield lambda done: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    columns = TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn()
    # What is printed meanwhile must not end up beside the bar, on standard error, where it was not meant to be.
    to_terminal = sys.stdout is not None and sys.stdout.isatty()
    bar = Progress(*columns, console=Console(stderr=True), transient=True, redirect_stdout=to_terminal)
    task = bar.add_task(what, total=None)

    def advance(done: float) -> None:
        bar.update(task, advance=done, total=total)

    # Known before it is shown: a signal may come in between.
    with _waits.told_to(bar, lambda text: bar.update(task, description=text or what)), bar:
        yield advance
