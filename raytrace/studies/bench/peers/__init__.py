"""What people would use instead, each written as its own users would write it; installed with the extra `bench`."""

from importlib.util import find_spec

__all__ = ["installed"]


def installed(module: str) -> bool:
    """Whether a peer is installed."""
    return find_spec(module) is not None
