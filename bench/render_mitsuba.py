"""render_mitsuba.py PROGRAM [SIZE [SAMPLES]]: how fast brdfit renders beside Mitsuba 3, LLVM variant.

The same picture by both, a sphere of rough metal (ggx) under an environment map with a small sun, direct light by one
direction to the light and one by the material, five times in turn: seconds from call to picture, brdfit's with the
start of its process. Says whether the pictures agree. Needs PyPI's mitsuba and LLVM 17 or later
(DRJIT_LIBLLVM_PATH names its library)."""

import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import mitsuba as mi
import numpy as np

REPEATS = 5


def sky(height):
    """A gradient with a sun, radiance in W/(m2 sr)."""
    y, x = np.mgrid[0:height, 0:2 * height]
    sun = 20 * np.exp(-((x - 0.6 * height) ** 2 + (y - 0.3 * height) ** 2) / (0.003 * height**2))
    return np.stack([0.3 + sun + 0.1 * (k + 1) * (y < height / 2) for k in range(3)], -1).astype(np.float32)


def scene(environment, size, samples):
    up = mi.ScalarTransform4f().rotate([0, 0, 1], 90) @ mi.ScalarTransform4f().rotate([1, 0, 0], 90)
    distance = 1.08 / np.sin(np.radians(12.5))  # as brdfit stands
    return mi.load_dict({
        "type": "scene",
        "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 1},
        "sensor": {
            "type": "perspective", "fov": 25,
            "to_world": mi.ScalarTransform4f().look_at(origin=[0, -distance, 0], target=[0, 0, 0], up=[0, 0, 1]),
            "sampler": {"type": "independent", "sample_count": samples},
            "film": {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}},
        },
        "sky": {"type": "envmap", "filename": str(environment), "to_world": up},
        "ball": {"type": "sphere", "bsdf": {"type": "roughconductor", "distribution": "ggx", "alpha": 0.2,
                                            "material": "none"}},
    })


def main(program, size=512, samples=64):
    mi.set_variant("llvm_ad_rgb")
    folder = pathlib.Path(tempfile.mkdtemp())
    environment, material, picture = folder / "sky.exr", folder / "metal.json", folder / "picture.exr"
    mi.util.write_bitmap(str(environment), sky(512), write_async=False)
    material.write_text(json.dumps({
        "brdfit": 1, "channels": ["grey"], "diffuse": {"model": "lambert", "kd": [0]},
        "lobes": [{"model": "ggx", "ks": [1], "f0": 1, "a": 0.2}]}))
    theirs, ours = [], []
    loaded = scene(environment, size, samples)
    for k in range(REPEATS + 1):  # the first compiles
        start = time.perf_counter()
        reference = np.array(mi.render(loaded, seed=k))
        theirs.append(time.perf_counter() - start)
        start = time.perf_counter()
        subprocess.run([program, "--quiet", "render", material, "--environment", environment, "--size", str(size),
                        "--samples", str(samples), "--pixel", "float", "-o", picture],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        ours.append(time.perf_counter() - start)
    rendered = np.array(mi.Bitmap(str(picture)))
    covered = rendered[..., 3] == 1
    blocks = [np.where(covered, p[..., 1], 0)[:size // 8 * 8, :size // 8 * 8]
              .reshape(size // 8, 8, size // 8, 8).mean((1, 3)) for p in (rendered, reference)]
    share = np.abs(blocks[0] - blocks[1]).mean() / blocks[1].mean()
    theirs, ours = statistics.median(theirs[1:]), statistics.median(ours[1:])
    print(f"Mitsuba {mi.__version__}: {theirs:.3f} s, brdfit: {ours:.3f} s, {theirs / ours:.2f} times as fast; "
          f"{rendered[..., 3].sum() * samples / ours / 1e6:.1f} million samples that meet the sphere a second; "
          f"the pictures differ by {100 * share:.2g} % of the mean, in blocks of 8 x 8")


if __name__ == "__main__":
    main(sys.argv[1], *(int(x) for x in sys.argv[2:]))
