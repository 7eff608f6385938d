"""Renders a material with Mitsuba 3 (pip install mitsuba).

python material_in_mitsuba.py [MATERIAL.json]"""

from __future__ import annotations

import sys

import mitsuba as mi
import numpy as np
import numpy.typing as npt

import brdfit


def main(file: str | None = None) -> npt.NDArray[np.float32]:
    mi.set_variant("scalar_rgb")
    material = (
        brdfit.Material.load(file)
        if file
        else brdfit.Material(diffuse=[0.05, 0.1, 0.3], lobes=[{"model": "ggx", "ks": 0.9, "f0": 0.05, "a": 0.1}])
    )
    camera = mi.ScalarTransform4f().look_at([0, -4, 1], [0, 0, 0], [0, 0, 1])
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 4},
            "sensor": {
                "type": "perspective",
                "fov": 35,
                "to_world": camera,
                "film": {"type": "hdrfilm", "width": 128, "height": 128},
            },
            "sky": {"type": "constant", "radiance": 0.3},
            "lamp": {"type": "point", "position": [3, -3, 4], "intensity": 40},
            "ball": {"type": "sphere", "bsdf": material.to_mitsuba()},
        }
    )
    image = mi.render(scene, spp=32)
    mi.Bitmap(image).write("ball.exr")
    return np.array(image)


if __name__ == "__main__":
    main(*sys.argv[1:2])
