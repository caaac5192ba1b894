"""What is said of arguments that JAX's explicit types spread over devices."""

import re
from collections.abc import Iterator
from contextlib import contextmanager

from raytrace.errors import InputError

__all__ = ["explicit_sharding_refused"]

_JAX_SAYS = re.compile(r"Resource axis: .* is not found in mesh|device assignment .* the size of the mesh")


@contextmanager
def explicit_sharding_refused() -> Iterator[None]:
    """Says in a line what JAX says, somewhere in the text, of types that are sharded: that is left to the compiler.

    Whether a batched argument has such a type, it does not tell before.
    """
    try:
        yield
    except ValueError as error:
        if isinstance(error, InputError) or not _JAX_SAYS.search(str(error)):
            raise
        raise InputError(
            "jax: render of arguments with an explicitly sharded type: make the mesh with axis_types "
            "jax.sharding.AxisType.Auto"
        ) from None
