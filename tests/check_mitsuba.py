"""check_mitsuba.py PROGRAM MATERIAL.json: whether Mitsuba 3 makes of an RGL file what brdfit does.

Writes MATERIAL as an RGL file by `PROGRAM convert`. Compares Mitsuba's values of the file with
`PROGRAM eval` of the file, and the mean weight of its sampler with `PROGRAM albedo` of the material.
Prints figures; exit status 1 where they differ, 77 where there is no Mitsuba."""

import csv
import math
import random
import subprocess
import sys
import tempfile

try:
    import mitsuba as mi
except ImportError:
    sys.exit(77)


def direction(z, phi):
    sine = math.sqrt(max(0, 1 - z * z))
    return [sine * math.cos(phi), sine * math.sin(phi), z]


def rows_of(path):
    with open(path) as file:
        return [[float(x) for x in row] for row in list(csv.reader(line for line in file if line[0] != "#"))[1:]]


def values_agree(program, file, bsdf, folder):
    rng = random.Random(1)
    pairs = [direction(rng.uniform(0.1, 1), rng.uniform(-math.pi, math.pi)) +
             direction(rng.uniform(0.1, 1), rng.uniform(-math.pi, math.pi)) for _ in range(2000)]
    pairs[::20] = [direction(pair[2], 0) + pair[3:] for pair in pairs[::20]]  # on the x axis exactly
    with open(folder + "/pairs.csv", "w") as out:
        print("wi_x,wi_y,wi_z,wo_x,wo_y,wo_z", file=out)
        for pair in pairs:
            print(*map(repr, pair), sep=",", file=out)
    subprocess.run([program, "eval", file, folder + "/pairs.csv", "-o", folder + "/f.csv"], check=True)
    context, surface = mi.BSDFContext(), mi.SurfaceInteraction3f()
    errors = []
    for pair, row in zip(pairs, rows_of(folder + "/f.csv")):
        surface.wi = pair[:3]
        theirs = [x / pair[5] for x in bsdf.eval(context, surface, pair[3:])]
        errors.append(max(abs(a - b) / max(abs(a), 1e-3) for a, b in zip(row[6:], theirs)))
    errors.sort()
    print(f"values: relative difference {errors[len(errors) // 2]:.2g} in the median, {errors[-20]:.2g} at the 99th percentile")
    return errors[-20] < 1e-3


def sampler_agrees(program, material, bsdf, folder):
    subprocess.run([program, "--quiet", "albedo", material, "--theta", "8", "-o", folder + "/albedo.csv"], check=True,
                   stdout=subprocess.DEVNULL)
    context, surface, rng, good = mi.BSDFContext(), mi.SurfaceInteraction3f(), random.Random(2), True
    rows = [row for row in rows_of(folder + "/albedo.csv") if row[0] < math.radians(80)]
    if any(row[1] > 0 for row in rows):
        rows = [row for row in rows if row[1] == 0][::3] + rows[::23]
    for theta, phi, *rest in rows:
        albedo = sum(rest[:3]) / 3
        surface.wi = direction(math.cos(theta), phi)
        count = 10000
        weights = [sum(bsdf.sample(context, surface, 0.5, ((i + rng.random()) / count, rng.random()))[1]) / 3
                   for i in range(count)]
        mean = sum(weights) / count
        variance = sum((w - mean) ** 2 for w in weights) / count
        print(f"{math.degrees(theta):.1f}, {math.degrees(phi):.1f} degrees: albedo {albedo:.5f}, mean weight {mean:.5f}, variance {variance:.2g}")
        good = good and abs(mean - albedo) < 0.01 * albedo and variance < 0.02
    return good


def main(program, material):
    mi.set_variant("scalar_rgb")
    with tempfile.TemporaryDirectory() as folder:
        file = folder + "/material.bsdf"
        subprocess.run([program, "convert", material, file], check=True)
        bsdf = mi.load_dict({"type": "measured", "filename": file})
        good = values_agree(program, file, bsdf, folder)
        return 0 if sampler_agrees(program, material, bsdf, folder) and good else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
