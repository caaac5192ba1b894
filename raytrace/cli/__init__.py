"""The command line: parse, call, print."""

import io
import logging
import os
import sys
from types import ModuleType
from typing import Annotated, Any

import typer

from raytrace.cli.groups import PLAIN, Commands
from raytrace.cli.guesses import with_a_hint
from raytrace.cli.signals import end_at_signals
from raytrace.cli.waits import show_waits
from raytrace.errors import EngineFailure, InputError
from raytrace.files import reason

__all__ = ["app", "run"]

app = typer.Typer(help="The reference implementation of the ray tracing assignment.", cls=Commands, **PLAIN)


@app.callback(invoke_without_command=True)
def _without_command(
    context: typer.Context,
    show_version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
    largest: Annotated[
        int | None,
        typer.Option("--largest-image", min=1, help="Images of more pixels are not read; by default 16384x16384."),
    ] = None,
) -> None:
    # What is imported here is not needed to print the help.
    if show_version:
        from importlib.metadata import version

        print(f"raytrace {version('raytrace')}")
    elif context.invoked_subcommand is None:
        print(context.get_help())
    else:
        import wrapt

        show_waits()
        # Hints are for those who write Python.
        logging.getLogger("raytrace").addFilter(lambda record: not hasattr(record, "hint"))
        wrapt.register_post_import_hook(_with_all_cores, "jax")
        if largest is not None:
            from raytrace.image import largest_image

            context.with_resource(largest_image(largest))


# The common base of typer's own errors, of which typer.BadParameter is one, wherever the class is kept.
_UsageError: Any = next(base for base in typer.BadParameter.__mro__ if base.__name__ == "ClickException")


#: Letters of a message.
LONGEST_LINE = 290

_RAN_AND_FAILED = 1


def run() -> None:
    """The command `raytrace`: 0 if all went well, 2 for bad input, with one line that says what; 130 for Ctrl-C;
    1 where something ran and failed."""
    # As 2>&- leaves it: the next file that is opened would be what messages are written to.
    for stream in (0, 1, 2):
        try:
            os.fstat(stream)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    end_at_signals()
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # a file's name need not be UTF-8
    try:
        code = app(standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
    except InputError as error:
        code = _failed(str(error))
    except EngineFailure as error:
        code = _failed(str(error), _RAN_AND_FAILED)
    except _UsageError as error:
        code = _failed(with_a_hint(error.format_message()))
    except BrokenPipeError:
        code = 0  # whoever reads has seen enough
    except OSError as error:
        code = _failed(f"standard output: cannot be written: {reason(error)}")
    except SystemExit as ended:
        code = ended.code
    # Not by way of the interpreter's end: after an error XLA may still be computing in a thread of its own, and would
    # crash when the interpreter is taken down under it.
    os._exit(code if isinstance(code, int) else 1 if code else 0)


def _with_all_cores(jax: ModuleType) -> None:
    """Before the command uses JAX, which it imports only where it does."""
    from raytrace.backends.jax.devices import use_all_cores

    use_all_cores()


def _failed(message: str, code: int = 2) -> int:
    if sys.stderr is not None:
        line = " ".join(message.split())
        shown = line if len(line) <= LONGEST_LINE else f"{line[: LONGEST_LINE - 4]} ..."
        print(f"raytrace: {shown}", file=sys.stderr, flush=True)
    return code
