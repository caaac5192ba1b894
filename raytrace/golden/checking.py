"""Golden images against those of another renderer."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from raytrace.certificates import Certificate, Verification, certify, read_certificate, verify
from raytrace.certificates.certificate import check_specification
from raytrace.certificates.verify import PROPOSAL, proposal
from raytrace.comparison import Comparison, failures
from raytrace.comparison.inputs import Picture, file_picture, read_picture, scene_in
from raytrace.errors import EngineFailure, InputError, did_you_mean
from raytrace.golden.golden import Golden, usual_bounds
from raytrace.golden.manifest import MANIFEST, file_hash, read_manifest
from raytrace.golden.writing import ACCEPTANCE, DISPLAY
from raytrace.image.formats import FORMATS
from raytrace.rendering import Options, Rendering
from raytrace.scene import Scene, scene_hash
from raytrace.scene.toml import scene_from_toml

__all__ = [
    "Checked",
    "GoldenFolder",
    "Source",
    "backend_source",
    "folder_source",
    "golden_folder",
    "one_image",
    "stray_images",
]

#: Gives the image to check, or its file, for a golden one.
Source = Callable[[Golden], Any]


@dataclass(frozen=True)
class Checked:
    """What came of one golden image: `failed` says what is wrong, and is empty where it passed.

    comparison: ``None`` where there is nothing to compare.
    verification: the image beside the bounds of what a conforming program may print, where there are any.
    """

    name: str
    failed: tuple[str, ...]
    comparison: Comparison | None = None
    verification: Verification | None = None

    def __str__(self) -> str:
        head = f"{'FAIL' if self.failed else 'ok':4}  {self.name:24}"
        c = self.comparison
        if c is None:
            return f"{head}  {'; '.join(self.failed)}"
        similarity = "undefined" if c.ssim is None else f"{c.ssim.mean:.6f}"
        line = f"{head}  SSIM {similarity}, {c.over} of {c.size[0] * c.size[1]} pixels over 1/255"
        if self.verification is not None:
            outside = int((self.verification.by > 0).sum())
            line += f", {outside} outside the bounds" if outside else ", inside the bounds"
        if not self.failed:
            return line
        proposed = next((said for said in self.failed if PROPOSAL in said), None)
        if proposed is not None:
            return f"{line}: {proposed}"
        return f"{line}: {c.diagnosis or '; '.join(self.failed)}"

    def to_dict(self) -> dict[str, Any]:
        """As plain types, for JSON."""
        compared = None if self.comparison is None else self.comparison.to_dict()
        verified = None if self.verification is None else self.verification.to_dict()
        return {"name": self.name, "failed": list(self.failed), "comparison": compared, "verification": verified}


@dataclass(frozen=True)
class GoldenFolder:
    """A folder of golden images.

    broken: by a scene's name what is wrong with its files.
    extra: files that belong to no golden image.
    certified: by a scene's name the bounds of what a conforming program may print, or their file.
    """

    goldens: tuple[Golden, ...]
    broken: Mapping[str, tuple[str, ...]]
    extra: tuple[str, ...]
    certified: Mapping[str, Path | Certificate] = field(default_factory=dict)

    def check(self, source: Source, bounds: Mapping[str, float] | None = None) -> Iterator[Checked]:
        """Compares the image that `source` gives for each golden one.

        Where the folder has certified bounds every pixel must keep these, and the image what `bounds` asks for; where
        it has none, `BOUNDS` and what `bounds` changes of them.
        What is broken or missing fails by name, and the others are still compared.
        """
        asked = dict(bounds or {})
        for golden in self.goldens:
            wrong = self.broken.get(golden.name, ())
            if wrong:
                yield Checked(golden.name, wrong)
                continue
            try:
                image = source(golden)
                if isinstance(image, str | Path):
                    image = read_picture(image, str(image), None, with_scene=False)
                comparison = golden.compare(image, image.name if isinstance(image, Picture) else "image")
            except (InputError, EngineFailure) as error:
                yield Checked(golden.name, (str(error),))
                continue
            yield self._checked(golden.name, image, comparison, asked)

    def _checked(self, name: str, image: Any, comparison: Comparison, asked: Mapping[str, float]) -> Checked:
        if name not in self.certified:
            return Checked(name, tuple(failures(comparison, {**usual_bounds(comparison), **asked})), comparison)
        # As the image is stored: the comparison has developed linear light, and rounded what is finer than the other.
        certificate = self.certified[name]
        if isinstance(certificate, Path):
            certificate = read_certificate(certificate)
        if isinstance(image, Picture):
            verification = verify(image.values, certificate, image.kind, image.depth)
        else:
            verification = verify(image, certificate)
        outside = () if verification.inside else tuple(str(verification).splitlines()[:2])
        if outside and isinstance(image, Picture):
            proposed = proposal(image.values, certificate, image.kind, image.depth)
            outside = outside if proposed is None else (*outside, proposed)
        return Checked(name, (*outside, *failures(comparison, asked)), comparison, verification)


def golden_folder(folder: str | Path) -> GoldenFolder:
    """The golden images of a folder that `raytrace golden` has made.

    Raises:
        InputError: it has no manifest, that is broken, or its images are of another specification.
    """
    folder = Path(folder)
    manifest = read_manifest(folder)
    check_specification(folder / MANIFEST, "golden images", manifest.specification, "raytrace golden")
    goldens, broken = [], {}
    for name, entry in manifest.scenes.items():
        scene = scene_from_toml(entry.toml, f"{folder / MANIFEST}: scenes.{name}.toml")
        goldens.append(Golden(name, scene, manifest.size, folder / f"{name}{DISPLAY}"))
        wrong = [problem for file, sha256 in entry.files.items() if (problem := _wrong(folder / file, sha256))]
        if scene_hash(scene) != entry.sha256:
            wrong.append(f"{MANIFEST}: the scene is not the one that was rendered")
        if wrong:
            broken[name] = tuple(wrong)
    ours = {MANIFEST, *(file for entry in manifest.scenes.values() for file in entry.files)}
    extra = sorted(path.name for path in folder.iterdir() if path.name not in ours)
    certified = {
        name: folder / f"{name}{ACCEPTANCE}"
        for name, entry in manifest.scenes.items()
        if f"{name}{ACCEPTANCE}" in entry.files
    }
    return GoldenFolder(tuple(goldens), broken, tuple(extra), certified)


def one_image(
    path: str | Path,
    scene: Scene | None = None,
    kind: str | None = None,
    layer: str | None = None,
    done: Callable[[float], object] = lambda share: None,
) -> tuple[GoldenFolder, Source]:
    """Return the golden image of one image's scene and size, with certified bounds, and what reads the image.

    scene: what it shows; by default what the file says. kind, layer: as of `folder_source`. done: is called with each
    share of the work that is done.

    Raises:
        InputError: there is no such image, or its scene is not known.
    """
    path = Path(path)
    picture = file_picture(path, kind=kind, layer=layer)
    known = scene or scene_in(picture.metadata, str(path))
    if known is None:
        raise InputError(f"{path}: does not say which scene it shows; give one (--scene)")
    height, width, _ = picture.values.shape
    bounds = certify(
        known, (width, height), precision="glsl-highp", done=lambda pixels: done(pixels / (width * height))
    )
    golden = Golden(path.stem, known, (width, height))
    held = GoldenFolder((golden,), {}, (), {path.stem: bounds})
    # Read again where its values are checked: NaN fails, as in a folder.
    return held, lambda golden: read_picture(path, str(path), kind, with_scene=False, layer=layer)


def backend_source(options: Options) -> Source:
    """Return what renders each golden image's scene with a backend, or with a user's shader on it."""

    def source(golden: Golden) -> Any:
        return Rendering(replace(options, scene=golden.scene, size=golden.size)).whole()

    return source


def folder_source(folder: str | Path, kind: str | None = None, layer: str | None = None) -> Source:
    """Return what reads each golden image's counterpart in a folder by the scene's name: NAME.png, NAME.exr, ...

    kind: "display" or "linear", what the files hold; by default what each says, or what its ending usually holds.
    layer: as of `raytrace.read_image`.

    Raises:
        InputError: there is no such folder.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder")

    endings = tuple(dict.fromkeys((DISPLAY, *FORMATS)))
    # Some systems write endings in capitals.
    files = {(path.stem, path.suffix.lower()): path for path in sorted(folder.iterdir()) if path.is_file()}

    def source(golden: Golden) -> Picture:
        for ending in endings:
            path = files.get((golden.name, ending))
            if path is not None:
                return read_picture(path, str(path), kind, with_scene=False, layer=layer)
        raise InputError(f"{folder}: missing: {golden.name} with one of {', '.join(endings)}")

    return source


def stray_images(folder: str | Path, names: Iterable[str]) -> list[str]:
    """Return a line for each image in a folder that is none of those scenes: a name may be misspelt."""
    names = list(names)
    strays = (
        path
        for path in sorted(Path(folder).iterdir())
        # NAME.png, and NAME.linear.exr as a folder of golden images has it.
        if path.suffix.lower() in FORMATS and path.name.partition(".")[0] not in names and path.stem not in names
    )
    return [f"{path}: is no golden image's; {did_you_mean(path.stem, names, 'there is')}" for path in strays]


def _wrong(path: Path, sha256: str) -> str:
    if not path.is_file():
        return f"{path}: missing"
    if file_hash(path) != sha256:
        return f"{path}: truncated or changed: not the file that was written"
    return ""
