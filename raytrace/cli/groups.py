"""The commands by what they are for. A command's module is imported when the command is asked for."""

import ast
from importlib import import_module
from importlib.resources import files
from typing import Any, NamedTuple

import typer
from typer.core import TyperGroup

__all__ = ["COMMANDS", "PLAIN", "Commands", "command"]

#: How Typer shows a command: as plain text, and errors are raised to whoever runs it.
PLAIN: dict[str, Any] = {"add_completion": False, "pretty_exceptions_enable": False, "rich_markup_mode": None}


class Place(NamedTuple):
    """Where a command's function is, within this package."""

    module: str
    function: str


#: As the help lists them: the groups, and in each the commands by name.
GROUPS: dict[str, dict[str, Place]] = {
    "Draw": {
        "render": Place("render", "render"),
        "scenes": Place("scenes", "list_scenes"),
        "show": Place("scenes", "show"),
        "pixel": Place("render", "pixel"),
        "export": Place("export", "export"),
    },
    "Check your renderer": {
        "compare": Place("compare", "compare"),
        "golden": Place("golden", "golden"),
        "check": Place("golden", "check"),
    },
    "Prove": {
        "certify": Place("certify", "certify"),
        "verify": Place("certify", "verify"),
        "conformance": Place("conformance", "conformance"),
    },
    "From images back": {
        "fit-sun": Place("inverse", "fit_sun"),
    },
    "Measure raytrace": {
        "bench": Place("bench", "bench"),
        "stress": Place("stress", "stress"),
        "mutants": Place("mutants", "mutants"),
        "gradients": Place("inverse", "gradients"),
        "sun-trials": Place("inverse", "sun_trials"),
    },
}
#: All commands by name.
COMMANDS = {name: place for group in GROUPS.values() for name, place in group.items()}


def command(name: str) -> Any:
    """Return the command of that name, imported."""
    place = COMMANDS[name]
    alone = typer.Typer(**PLAIN)
    alone.command(name)(getattr(import_module(f"raytrace.cli.{place.module}"), place.function))
    return typer.main.get_command(alone)


class Commands(TyperGroup):
    """All commands."""

    def __init__(self, **attributes: Any):
        super().__init__(**attributes)
        self.commands: Any = dict.fromkeys(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        if cmd_name not in self.commands:
            return None
        self.commands[cmd_name] = self.commands[cmd_name] or command(cmd_name)
        return self.commands[cmd_name]

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a section for each group: the summaries are read, and nothing is imported."""
        widest = max(map(len, COMMANDS))
        for group, places in GROUPS.items():
            with formatter.section(group):
                formatter.write_dl([(name.ljust(widest), _summary(place)) for name, place in places.items()])


def _summary(place: Place) -> str:
    """The first line of the command's docstring."""
    text = ast.parse((files("raytrace.cli") / f"{place.module}.py").read_text("utf-8"))
    (function,) = (each for each in text.body if isinstance(each, ast.FunctionDef) and each.name == place.function)
    return (ast.get_docstring(function) or "").partition("\n")[0]
