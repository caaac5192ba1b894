"""What users of other tools try first, and what it is called here."""

import re

__all__ = ["with_a_hint"]

_SIZE = "--size WIDTHxHEIGHT"
_SAMPLES = "--samples N, for N x N samples a pixel"
#: Options by the name that is tried, and what does the same.
_OPTIONS = {
    "--width": _SIZE,
    "--height": _SIZE,
    "--res": _SIZE,
    "--resolution": _SIZE,
    "--spp": _SAMPLES,
    "--aa": "--antialias edges",
    "--fov": "--set camera.fov=40",
    "--azimuth": "--set sun.azimuth=120",
    "--elevation": "--set sun.elevation=30",
    "--sun": "--set sun.direction=[1,0.75,1]",
    "--exposure": "--set film.exposure=1",
    "--precision": "--dtype float64",
    "--format": "the ending of the file's name, -o a.exr",
    "--output-file": "-o FILE",
    "--reference": "--against REFERENCE",
    "--min-ssim": "--require 'ssim>=0.9999'",
    "--max-rmse": "--require 'rmse<=0.001'",
    "--max-share": "--require 'share<=0.001'",
    "--max-flip": "--require 'flip<=0.01'",
    "--max-difference": "--require 'difference<=0.004'",
    "--threshold": "--require 'ssim>=0.9999'",
}
#: Commands in the same way.
_COMMANDS = {
    "diff": "compare",
    "draw": "render",
    "image": "render",
    "info": "show",
    "list": "scenes",
    "test": "check",
    "validate": "check",
    "benchmark": "bench",
    "debug": "pixel",
    "fit": "fit-sun",
    "open": "view",
}


def with_a_hint(message: str) -> str:
    """Return a message of a wrong option or command, and what was probably meant."""
    option = re.match(r"No such option: (--[\w-]+)", message)
    if option and option[1] in _OPTIONS:
        return f"No such option: {option[1]}; there is {_OPTIONS[option[1]]}"
    command = re.match(r"No such command '([\w-]+)'", message)
    if command and command[1] in _COMMANDS:
        return f"No such command '{command[1]}'; there is 'raytrace {_COMMANDS[command[1]]}'"
    return message
