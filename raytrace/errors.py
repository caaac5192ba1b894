"""What can go wrong: an error that a user can mend, and a failure of something that was run."""

import difflib
from collections.abc import Iterable

__all__ = ["EngineFailure", "InputError", "check_choice", "did_you_mean", "unknown"]


class InputError(ValueError):
    """Something that was asked for cannot be: one line of what, where, and what would be right.

    The command line prints the line and exits with 2.
    """


class EngineFailure(RuntimeError):
    """A graphics engine, or a shader on it, failed while it ran: it crashed, or did not end in time.

    The command line prints the line and exits with 1.
    """


def check_choice(what: str, found: object, known: Iterable[str]) -> None:
    """Check that `found` is one of the names `known`; `what` it chooses begins the message.

    Raises:
        InputError: it is another, or no name at all.
    """
    known = list(known)
    if found not in known:
        raise InputError(f"{what}: {unknown(found, known)}")


def unknown(found: object, known: Iterable[str]) -> str:
    """Return what is said of a name that is not among `known`."""
    return f"unknown {found!r}; {did_you_mean(str(found), known, 'there is')}"


def did_you_mean(found: str, names: Iterable[str], what: str) -> str:
    """Return the end of a message about a name that is not among `names`: the nearest one, and all, called `what`."""
    names = list(names)
    near = difflib.get_close_matches(found, names, n=1)
    guess = f"did you mean '{near[0]}'? " if near else ""
    return f"{guess}{what}: {', '.join(names)}"
