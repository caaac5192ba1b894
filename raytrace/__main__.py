"""The command: `python -m raytrace`, and the script `raytrace`."""

import os
import sys

__all__ = ["main"]


def main() -> None:
    """Run the command; an interruption is quiet, too, while its modules are imported."""
    try:
        from raytrace.cli import run
    except KeyboardInterrupt:
        print("raytrace: interrupted", file=sys.stderr, flush=True)
        os._exit(130)
    run()


if __name__ == "__main__":
    main()
