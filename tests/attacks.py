"""Attacks on the command: inputs that people have by accident or on purpose, in seven groups.

``python -m tests.attacks [--count N] [--seed S]`` runs so many, spread over the groups, and prints how many held. An
attack holds if the command ends in time with the exit code 0, 1 or 2, says at most one line of at most 300 letters on
standard error unless it went well, and leaves nothing half-written. Exit code 1 if one did not.
"""

import argparse
import os
import random
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests.processes import command

__all__ = ["GROUPS", "Outcome", "attacks", "run"]

#: Seconds that one may take: with the start of an engine.
LONGEST = 100


class Attack(NamedTuple):
    """What is done: `prepare` writes files into the current folder and gives the command's arguments."""

    group: str
    name: str
    prepare: Callable[[Path, random.Random], list[str]]


class Outcome(NamedTuple):
    """What came of an attack; `wrong` says why it did not hold, and is empty where it did."""

    group: str
    name: str
    wrong: str


def _png(folder: Path) -> Path:
    import raytrace

    path = folder / "good.png"
    raytrace.write_image(path, np.linspace(0, 1, 16 * 16 * 3).reshape(16, 16, 3))
    return path


def _images(folder: Path, chance: random.Random) -> list[str]:
    """A damaged image, given to one of the commands that read images."""
    import raytrace

    ending = chance.choice(["png", "exr", "tif"])
    path = folder / f"a.{chance.choice([ending, ending.upper()])}"
    size = chance.choice([(16, 16), (1, 1), (7, 3)])
    image = np.random.default_rng(chance.randrange(99)).random((*size, 3))
    if chance.random() < 0.3:
        image[0, 0] = chance.choice([-1, 1e30, 65505])
    good = folder / f"b.{ending}"
    raytrace.write_image(good, np.clip(image, 0, 1) if ending == "png" else image)
    data = bytearray(good.read_bytes())
    how = chance.choice(["cut", "flip", "empty", "text", "header", "swap", "as it is"])
    if how == "cut":
        data = data[: chance.randrange(len(data))]
    elif how == "flip":
        for _ in range(chance.randrange(1, 20)):
            data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    elif how == "empty":
        data = bytearray()
    elif how == "text":
        data = bytearray(b"this is no image\n" * chance.randrange(1, 999))
    elif how == "header":
        data[chance.randrange(4, 32)] = chance.randrange(256)
    elif how == "swap":
        path = path.with_suffix(chance.choice([".png", ".exr", ".tif", ".jpg", ".hdr"]))
    path.write_bytes(data)
    return chance.choice(
        [
            ["compare", str(path), str(good)],
            ["compare", str(good), str(path), "--scene", "sphere", "--json"],
            ["verify", str(path), "--scene", "sphere"],
            ["fit-sun", str(path), "--scene", "sphere"],
        ]
    )


_WORDS = [
    *(
        "#version 300 es",
        "#version",
        "#version 100",
        "#version 450 core",
        "#include <a>",
        "#define A A",
        "#if",
        "#endif",
    ),
    *("precision highp float;", "in vec2 uv;", "varying vec2 uv;", "out vec4 c;", "uniform vec3 sunDirection;"),
    *("uniform Scene { vec3 camPos; };", "uniform float spheres[3];", "buffer B { float x[]; };", "void main(){", "}"),
    *(
        "c = vec4(uv, 0., 1.);",
        "c = vec4(sunDirection, 1.);",
        "discard;",
        "for(;;);",
        "/*",
        "*/",
        "//",
        "\\",
        "\0",
        "é",
    ),
    *("void mainImage(out vec4 c, in vec2 p){ c = vec4(p, iTime, 1.); }", "gl_FragColor = vec4(1.);", "uniform int n;"),
]


def _shaders(folder: Path, chance: random.Random) -> list[str]:
    """A shader of random words, or a good one with words missing."""
    if chance.random() < 0.5:
        words = chance.choices(_WORDS, k=chance.randrange(12))
    else:
        words = [_WORDS[i] for i in (0, 8, 9, 11, 14, 16, 15)]
        for _ in range(chance.randrange(3)):
            words[chance.randrange(len(words))] = chance.choice(_WORDS)
    path = folder / "a.frag"
    path.write_text(chance.choice(["\n", " ", "\r\n"]).join(words))
    uniform = chance.choice(
        [[], [], ["--uniform", chance.choice(["n=1", "n=[1,", "=", "n=nan", "n=1e400", "constructor=1"])]]
    )
    return [
        "render",
        "sphere",
        "--backend",
        "opengl",
        "--size",
        "8x8",
        "--time-limit",
        "5",
        "--shader",
        str(path),
        *uniform,
    ]


_VALUES = [
    *("1e999", "-1", "0", "nan", "''", "true", "[]", "[1]", "[[[]]]", "{}", "9" * 5000, "1.5", "[0,0,0]", "[nan,0,0]"),
    *("1979-05-27", "'$x$'", "[" * 3000, "{a=" * 500, "0x" + "f" * 400, "[1e300,0,0]", "'checkerboard'", '"\\u0000"'),
]
_KEYS = [
    *("sun.direction", "spheres", "spheres[0].radius", "spheres[999999999999].radius", "camera", "camera.position"),
    *(
        "film.exposure",
        "film.tone_mapper",
        "planes[0].pattern.tile_size",
        "a",
        "a." * 3000 + "a",
        "",
        ".",
        "spheres[-1]",
    ),
]


def _scenes(folder: Path, chance: random.Random) -> list[str]:
    """A scene file, or a change to a scene, with wrong values, deep nesting, long names."""
    key, value = chance.choice(_KEYS), chance.choice(_VALUES)
    if chance.random() < 0.5:
        return ["render", "checkerboard", "--backend", "numpy", "--size", "8x8", "--set", f"{key}={value}"]
    path = folder / "a.toml"
    how = chance.choice(["text", "bytes", "folder", "missing", "pipe"])
    if how == "text":
        path.write_text(f"{key} = {value}\n" if chance.random() < 0.7 else f"[{key}]\n{value}")
    elif how == "bytes":
        path.write_bytes(chance.randbytes(200))
    elif how == "folder":
        path.mkdir()
    elif how == "pipe" and hasattr(os, "mkfifo"):
        os.mkfifo(path)
    return [chance.choice(["render", "show"]), str(path)]


def _outputs(folder: Path, chance: random.Random) -> list[str]:
    """Outputs that cannot be written, or must not be."""
    image = _png(folder)
    how = chance.choice(["device", "folder", "missing", "link", "itself", "ending", "long", "full", "odd"])
    out = {
        "device": "/dev/null",
        "folder": str(folder),
        "missing": str(folder / "no" / "a.png"),
        "link": str(folder / "link.png"),
        "itself": str(image),
        "ending": str(folder / f"a.{chance.choice(['', 'bmp', 'frag', 'p ng'])}"),
        "long": str(folder / ("a" * 300 + ".png")),
        "full": "/dev/full",
        "odd": str(folder / chance.choice(["-.png", " .png", "é.png", "[a].png", "$x^2$.png", "a\nb.png"])),
    }[how]
    if how == "link":
        (folder / "link.png").symlink_to(chance.choice([image, folder / "none.exr", "/dev/null", folder / "link.png"]))
    return chance.choice(
        [
            ["render", "sphere", "--backend", "numpy", "--size", "8x8", "-o", out],
            ["compare", str(image), str(image), "--diff", out],
            ["export", "sphere", "--to", "glsl", "-o", out],
            ["verify", str(image), "--scene", "sphere", "--marked", out],
        ]
    )


def _options(folder: Path, chance: random.Random) -> list[str]:
    """Sizes, names and numbers that are none."""
    size = chance.choice(["8x8", "0x0", "-1x8", "8", "x", "8x8x8", "1e3x8", "99999999999x1", "\u0668x8", ""])
    option = chance.choice(
        [
            *(["--backend", name] for name in ("numpy", "cuda", "", "jax ", "numpy:float64")),
            *(["--dtype", name] for name in ("float16", "float32", "int", "longdouble")),
            *(["--samples", number] for number in ("0", "-1", "1.5", "99999999", "nan")),
            *(["--time-limit", number] for number in ("inf", "0", "1e18", "nan")),
            *(["--hosts", number] for number in ("1000000000", "0", "-1")),
            *(["--wait", number] for number in ("inf", "nan", "-1")),
            *(["--largest-image", number] for number in ("0", "-1")),
            *([f"--{name}"] for name in ("cluster=1", "nothing", "uniform", "shader")),
        ]
    )
    scene = chance.choice(["sphere", "sphere", "no-such-scene", "", "-", "sphere.toml", "../sphere"])
    if option[0] == "--samples" and option[1] == "99999999":
        size = "1x1"
    return ["render", scene, "--backend", "numpy", "--size", size, *option]


def _goldens(folder: Path, chance: random.Random) -> list[str]:
    """Folders of golden images that somebody has changed."""
    golden = folder / chance.choice(["g", "g[1]", "g *", "é"])
    made = command("golden", golden, "--size", "8x8", "--scenes", "sphere", cwd=folder)
    if made.returncode:
        return ["check", str(golden)]
    manifest = golden / "manifest.json"
    manifest = manifest if manifest.exists() else next(path for path in golden.iterdir() if "manifest" in path.name)
    text = manifest.read_text()
    how = chance.choice(["cut", "flip", "names", "size", "numbers", "image", "none"])
    if how == "cut":
        text = text[: chance.randrange(len(text))]
    elif how == "flip":
        at = chance.randrange(len(text))
        text = text[:at] + chance.choice('{}[]",0') + text[at + 1 :]
    elif how == "names":
        text = text.replace("sphere", chance.choice(["../sphere", "/etc/passwd", "", "a" * 3000]))
    elif how == "size":
        text = text.replace("8", chance.choice(["65536", "-1", "1e9"]), 1)
    elif how == "numbers":
        text = text.replace("1", "9" * 5000, 1)
    elif how == "image":
        (golden / "sphere.png").write_bytes(struct.pack("<I", chance.randrange(1 << 32)))
    manifest.write_text(text)
    return ["check", str(golden), "--backend", "numpy"]


def _certificates(folder: Path, chance: random.Random) -> list[str]:
    """Certificates with bytes, or fields, that are not theirs."""
    image, path = _png(folder), folder / "a.npz"
    command("certify", "sphere", "--size", "16x16", "-o", path, cwd=folder)
    data = bytearray(path.read_bytes()) if path.exists() else bytearray(b"none")
    for _ in range(chance.randrange(1, 6)):
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    path.write_bytes(data[: chance.choice([len(data), chance.randrange(len(data))])])
    return ["verify", str(image), "--certificate", str(path)]


GROUPS: dict[str, Callable[[Path, random.Random], list[str]]] = {
    "images": _images,
    "shaders": _shaders,
    "scenes": _scenes,
    "outputs": _outputs,
    "options": _options,
    "goldens": _goldens,
    "certificates": _certificates,
}


def attacks(count: int) -> Iterator[Attack]:
    """So many attacks, one of each group after the other."""
    groups = list(GROUPS.items())
    for number in range(count):
        group, prepare = groups[number % len(groups)]
        yield Attack(group, f"{group}-{number // len(groups)}", prepare)


def run(attack: Attack, seed: int = 0) -> Outcome:
    """Attack once, in a folder of its own; the same seed does the same."""
    chance = random.Random(f"{seed} {attack.name}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        arguments = attack.prepare(folder, chance)
        before = {path.name for path in folder.iterdir()}
        done = command(*arguments, cwd=folder, limit=LONGEST)
        after = {path.name for path in folder.iterdir()}
        return Outcome(*attack[:2], _wrong(done, before, after, arguments))


def _wrong(done: subprocess.CompletedProcess, before: set[str], after: set[str], arguments: list[str]) -> str:
    said = [line for line in done.stderr.splitlines() if line.strip()]
    shown = f"{' '.join(arguments)[:300]!r}: exit code {done.returncode}, {' / '.join(said)[-300:]}"
    if done.returncode not in (0, 1, 2):
        return f"ended otherwise: {shown}"
    if any("Traceback" in line for line in said):
        return f"a traceback: {shown}"
    if done.returncode and (len(said) > 1 or max(map(len, said), default=0) > 300):
        return f"not one line of 300 letters: {shown}"
    if done.returncode == 2 and not said:
        return f"says nothing: {shown}"
    if any(name.startswith(".") for name in after - before):
        return f"left {after - before}: {shown}"
    if done.returncode == 2 and after - before:
        return f"wrote {after - before} although the input is bad: {shown}"
    return ""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    held: dict[str, list[bool]] = {}
    for attack in attacks(given.count):
        outcome = run(attack, given.seed)
        held.setdefault(outcome.group, []).append(not outcome.wrong)
        if outcome.wrong:
            print(f"{outcome.name}: {outcome.wrong}", flush=True)
    for group, each in held.items():
        print(f"{group:14} tried {len(each):4}  held {sum(each):4}")
    everything = [one for each in held.values() for one in each]
    print(f"{'all':14} tried {len(everything):4}  held {sum(everything):4}")
    sys.exit(0 if all(everything) else 1)


if __name__ == "__main__":
    main()
