"""What can go wrong: an error that a user can mend, and a failure of something that was run."""

import difflib
from collections.abc import Iterable

__all__ = ["EngineFailure", "InputError", "did_you_mean"]


class InputError(ValueError):
    """Something that was asked for cannot be: one line of what, where, and what would be right.

    The command line prints the line and exits with 2.
    """


class EngineFailure(RuntimeError):
    """A graphics engine, or a shader on it, failed while it ran: it crashed, or did not end in time.

    The command line prints the line and exits with 1.
    """


def did_you_mean(found: str, names: Iterable[str], what: str) -> str:
    """The end of a message about a name that is not among `names`: the nearest one, and all, called `what`."""
    names = list(names)
    near = difflib.get_close_matches(str(found), names, n=1)
    guess = f"did you mean '{near[0]}'? " if near else ""
    return f"{guess}{what}: {', '.join(names)}"
