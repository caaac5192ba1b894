"""The package colour-science, which takes seconds to import: only where it is used."""

import warnings
from typing import Any

__all__ = ["colour_science"]


def colour_science() -> Any:
    """The module ``colour``, imported without its warnings of what it could do if more were installed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour

    return colour
