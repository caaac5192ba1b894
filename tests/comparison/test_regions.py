import numpy as np

import raytrace
from raytrace.comparison.reference import Reference
from raytrace.comparison.regions import regions
from tests.strategies import many

SIZE = 160, 90


def rendered(*changes, scene="checkerboard"):
    return raytrace.render(raytrace.load_scene(scene, changes), SIZE, backend="numpy", dtype="float64")


def parts(*changes):
    found = raytrace.compare(rendered(), rendered(*changes), scene="checkerboard")
    return {region.name: region for region in found.regions}, found.over


def test_the_parts_are_the_whole_image():
    found, over = parts("sun.color=[1,1,1]")
    whole = [region for name, region in found.items() if name not in ("shadow", "edges")]
    assert sum(region.pixels for region in whole) == SIZE[0] * SIZE[1]
    assert sum(region.over for region in whole) == over


def test_a_spheres_colour_lives_in_that_sphere():
    found, over = parts("spheres[2].color=[0.8,0.3,0.8]")
    assert found["sphere 2"].over == over == found["sphere 2"].pixels


def test_a_pattern_lives_in_its_plane():
    found, over = parts("planes[0].pattern.odd=[0.4,0.1,0.1]")
    assert found["plane 0"].over == over > 0


def test_missing_shadows_live_in_the_shadow():
    found, over = parts("lighting='on'")
    assert found["shadow"].over == over > 0
    assert found["sky"].over == 0


def test_the_suns_disc_lives_in_the_sky():
    changes = ["camera.target=[1,1.25,3]", "planes=[]"]
    scene = raytrace.load_scene("checkerboard", changes)
    without = rendered(*changes, "sun.direction=[-1,0.75,1]")
    found = raytrace.compare(rendered(*changes), without, scene=scene)
    assert {region.name for region in found.regions} == {"sky", "edges"}
    assert found.regions[0].over == found.over > 0


def test_edges_are_pixels_that_border_on_another_surface():
    """One sphere before the sky: its silhouette and the horizon, two pixels wide; nothing where all is one colour."""
    scene = raytrace.load_scene("sphere")
    reference = Reference(scene, 64, 64)
    index = reference.steps["index"]
    everything = np.ones(index.shape, bool)
    edges = next(region for region in regions(everything, reference) if region.name == "edges")
    sideways = (np.diff(index, axis=1) != 0).sum()
    assert 2 * sideways < edges.over < index.size / 4


def test_many_spheres_and_parts_that_are_not_seen():
    scene = raytrace.Scene(spheres=many(40))
    reference = Reference(scene, 64, 36)
    names = [region.name for region in regions(np.zeros((36, 64), bool), reference)]
    seen = set(np.unique(reference.steps["index"])) - {-1}
    assert {name for name in names if name.startswith("sphere")} == {f"sphere {index}" for index in seen}
