"""check_sphere.py PROGRAM FILE.bsdf [FOLDER]: whether Mitsuba 3 makes the same picture of an RGL file and of
what brdfit makes of it.

Renders a sphere under a distant light and a faint sky: twice from FILE, with different seeds, and once from each
of what `PROGRAM convert FILE` writes, with the file's tables and with tables made anew. With the file's tables the
pictures may differ by no more than the two of FILE, pixel by pixel and in blocks of 8 x 8, in which noise is an
eighth; with others by 1 % in blocks. Prints figures; keeps the pictures in FOLDER. Exit status 1 where they differ
by more, 77 where there is no Mitsuba."""

import math
import pathlib
import subprocess
import sys
import tempfile

try:
    import mitsuba as mi
except ImportError:
    sys.exit(77)

SIDE, SAMPLES, BLOCK = 96, 256, 8


def rendered(file, seed):
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "sensor": {
            "type": "perspective", "fov": 26,
            "to_world": mi.ScalarTransform4f().look_at(origin=[0, -5, 0], target=[0, 0, 0], up=[0, 0, 1]),
            "sampler": {"type": "independent", "sample_count": SAMPLES},
            "film": {"type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": "box"}},
        },
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 0.3}},
        "light": {"type": "directional", "direction": [3, 4, -4], "irradiance": {"type": "rgb", "value": 2.0}},
        "ball": {"type": "sphere", "bsdf": {"type": "measured", "filename": str(file)}},
    }
    return mi.render(mi.load_dict(scene), seed=seed)


def values(picture):
    """Row by row, R, G and B of each pixel."""
    return [float(x) for x in picture.array]


def blocks(pixels):
    sums = [0.0] * (3 * (SIDE // BLOCK) ** 2)
    for i, value in enumerate(pixels):
        y, x, channel = i // 3 // SIDE, i // 3 % SIDE, i % 3
        sums[(y // BLOCK * (SIDE // BLOCK) + x // BLOCK) * 3 + channel] += value / BLOCK**2
    return sums


def rms(a, b):
    """Root mean square of all differences but the largest tenth: the rim has a few very bright pixels."""
    squares = sorted((x - y) ** 2 for x, y in zip(a, b))
    kept = squares[:len(squares) * 9 // 10]
    return math.sqrt(sum(kept) / len(kept))


def compare(a, b):
    """The differences of pixels and of blocks, and the median of those of blocks, in units of b's mean."""
    mean = sum(b) / len(b)
    brighter = sorted(x - y for x, y in zip(blocks(a), blocks(b)))
    return rms(a, b) / mean, rms(blocks(a), blocks(b)) / mean, brighter[len(brighter) // 2] / mean


def main(program, file, folder):
    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)  # of colours out of gamut, which it drops
    folder = pathlib.Path(folder)
    picture = rendered(file, 1)
    mi.util.write_bitmap(str(folder / "original.png"), picture)
    original = values(picture)
    noise, block_noise, _ = compare(values(rendered(file, 2)), original)
    print(f"the file twice: pixels differ by {noise:.3g} of the mean, blocks by {block_noise:.3g}")
    good = True
    for seed, (name, options) in enumerate({"kept": [], "anew": ["--size", "32,64"]}.items(), 3):
        made = folder / f"{name}.bsdf"
        subprocess.run([program, "--quiet", "convert", file, str(made), *options], check=True,
                       stdout=subprocess.DEVNULL)
        picture = rendered(made, seed)
        mi.util.write_bitmap(str(folder / f"{name}.png"), picture)
        error, block_error, brighter = compare(values(picture), original)
        print(f"tables {name}: pixels {error:.3g}, blocks {block_error:.3g}, the median block {brighter:+.2g}")
        most = (1.1 * noise, 1.25 * block_noise) if name == "kept" else (2 * noise, 0.01)
        good = good and error < most[0] and block_error < most[1]
    return 0 if good else 1


if __name__ == "__main__":
    if len(sys.argv) > 3:
        sys.exit(main(*sys.argv[1:]))
    with tempfile.TemporaryDirectory() as temporary:
        sys.exit(main(*sys.argv[1:3], temporary))
