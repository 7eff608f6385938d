"""Materials in Mitsuba 3, where it is installed."""

import numpy as np
import pytest

from conftest import random_pairs

mi = pytest.importorskip("mitsuba")


def test_mitsuba_evaluates_a_material_as_it_is(plastic):
    mi.set_variant("scalar_rgb")
    bsdf = mi.load_dict(plastic.to_mitsuba())
    wi, wo = random_pairs(300, seed=3)
    keep = (wi[:, 2] > 0.2) & (wo[:, 2] > 0.2)
    wi, wo = wi[keep], wo[keep]
    context, surface = mi.BSDFContext(), mi.SurfaceInteraction3f()
    theirs = []
    for light, viewer in zip(wi, wo):
        surface.wi = viewer.tolist()  # Mitsuba's wi is the viewer
        theirs.append(np.array(bsdf.eval(context, surface, light.tolist())) / light[2])
    ours = plastic.eval(wi, wo)
    np.testing.assert_allclose(np.median(np.abs(np.array(theirs) / ours - 1)), 0, atol=0.01)


def test_mitsuba_renders_a_material(plastic):
    mi.set_variant("scalar_rgb")
    scene = mi.load_dict({
        "type": "scene", "integrator": {"type": "direct"}, "light": {"type": "constant"},
        "sensor": {"type": "perspective", "fov": 30, "to_world": mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]),
                   "film": {"type": "hdrfilm", "width": 16, "height": 16}},
        "ball": {"type": "sphere", "bsdf": plastic.to_mitsuba()},
    })  # fmt: skip
    image = np.array(mi.render(scene, spp=16))
    centre = image[6:10, 6:10, :3].mean(axis=(0, 1))
    albedo, _ = plastic.albedo(0.1)
    np.testing.assert_allclose(centre, albedo, rtol=0.1)
