"""`python -m raytrace`: the command."""

from raytrace.cli import run

run()
