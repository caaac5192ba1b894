"""The commands by what they are for. A command's module is imported when the command is asked for."""

import ast
from importlib import import_module
from importlib.resources import files
from typing import Any, ClassVar, NamedTuple

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
        "view": Place("export", "view"),
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
}
#: The name of the command that has commands of its own, for those who develop raytrace itself.
MEASURE = "measure"
MEASUREMENTS = {
    "bench": Place("bench", "bench"),
    "stress": Place("stress", "stress"),
    "mutants": Place("mutants", "mutants"),
    "gradients": Place("inverse", "gradients"),
    "sun-trials": Place("inverse", "sun_trials"),
}
#: All of them by name. Measurements may also be asked for without `measure`.
COMMANDS = {name: place for group in (*GROUPS.values(), MEASUREMENTS) for name, place in group.items()}


def command(name: str) -> Any:
    """Return the command of that name, imported."""
    if name == MEASURE:
        return _measure()
    place = COMMANDS[name]
    alone = typer.Typer(**PLAIN)
    alone.command(name)(getattr(import_module(f"raytrace.cli.{place.module}"), place.function))
    return typer.main.get_command(alone)


class _Lazy(TyperGroup):
    """Commands that are imported when they are asked for."""

    #: As the help lists them.
    groups: ClassVar[dict[str, dict[str, Place]]]

    def __init__(self, **attributes: Any):
        super().__init__(**attributes)
        self.commands: Any = dict.fromkeys(name for group in self.groups.values() for name in group)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        if cmd_name not in self.commands:
            return None
        self.commands[cmd_name] = self.commands[cmd_name] or command(cmd_name)
        return self.commands[cmd_name]

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a section for each group: the summaries are read, and nothing is imported."""
        widest = max(len(name) for group in self.groups.values() for name in group)
        for group, places in self.groups.items():
            with formatter.section(group):
                formatter.write_dl([(name.ljust(widest), _summary(place)) for name, place in places.items()])


class Measurements(_Lazy):
    """The commands after `measure`."""

    groups: ClassVar = {"Measure raytrace": MEASUREMENTS}


class Commands(_Lazy):
    """All commands."""

    groups: ClassVar = GROUPS | {f"Measure raytrace: 'raytrace {MEASURE} ...'": MEASUREMENTS}

    def __init__(self, **attributes: Any):
        super().__init__(**attributes)
        self.commands[MEASURE] = None


def _measure() -> Any:
    """The command `measure`."""
    several = typer.Typer(name=MEASURE, help="Measure raytrace itself.", cls=Measurements, **PLAIN)

    @several.callback(invoke_without_command=True)
    def without_command(context: typer.Context) -> None:
        if context.invoked_subcommand is None:
            print(context.get_help())

    return typer.main.get_command(several)


def _summary(place: Place) -> str:
    """The first line of the command's docstring."""
    text = ast.parse((files("raytrace.cli") / f"{place.module}.py").read_text("utf-8"))
    (function,) = (each for each in text.body if isinstance(each, ast.FunctionDef) and each.name == place.function)
    return (ast.get_docstring(function) or "").partition("\n")[0]
