#!/usr/bin/env python3
"""Fitted models in a scene with global illumination: a table of the measured material, seen at a grazing angle, as
Fig. 9 of Kurt et al. 2010 shows one of nickel. Mitsuba 3 (pip install mitsuba numpy) renders it.

python table.py nickel.binary -o out/table

fits every model to FILE, writes FILE and the materials as .bsdf files, and renders the scene with each. Prints the
peak signal-to-noise ratio of each against the picture of FILE itself, as `brdfit render --compare` defines it, and
that of a second picture of FILE with other random numbers: more than that no model can have. FOLDER gets the
pictures (linear .exr), the materials, psnr.csv, and strip.jpg: FILE, kurt, the best and the worst model."""

from __future__ import annotations

import argparse
import csv
import json
import math
import multiprocessing
import os
import pathlib
import subprocess
import sys
import time

try:
    import mitsuba as mi
    import numpy as np
except ImportError as error:
    sys.exit(f"table.py: {error}; expected Mitsuba 3 and NumPy: pip install mitsuba numpy")

REFERENCE, AGAIN = "measured", "measured again"  # the latter with other random numbers
# Paths that Mitsuba's LLVM variant follows at a time, some hundred bytes each, and samples of a pixel that its sampler
# spreads evenly.
PATHS_A_PASS, SAMPLES_A_PASS = 2**24, 256
# Of a .bsdf: incidences and the square's side. The same for all, so that tables do not differ by their size.
NODES = "64,128"


def scene(bsdf: pathlib.Path, width: int, height: int, bounces: int) -> dict:
    """The table is of the material, everything else diffuse. Metres, z up; the top is at 0.78, 1.8 by 1.4.

    The camera looks 12 degrees down at the middle of the top, 17 at its near edge, 9 at its far one."""
    place = mi.ScalarTransform4f
    metal = {"type": "measured", "filename": str(bsdf)}

    def diffuse(*colour):
        return {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(colour)}}

    def box(x, y, z, half_x, half_y, half_z, bsdf, turn=0):
        to_world = place().translate([x, y, z]).rotate([0, 0, 1], turn).scale([half_x, half_y, half_z])
        return {"type": "cube", "to_world": to_world, "bsdf": bsdf}

    def lamp(x, y, z, half_x, half_y, target, radiance):
        to_world = place().look_at(origin=[x, y, z], target=target, up=[0, 1, 0]).scale([half_x, half_y, 1])
        return {"type": "rectangle", "to_world": to_world,
                "emitter": {"type": "area", "radiance": {"type": "rgb", "value": radiance}}}  # fmt: skip

    checks = {"type": "checkerboard", "to_uv": place().scale([12, 12, 1]),
              "color0": {"type": "rgb", "value": [0.5, 0.42, 0.32]},
              "color1": {"type": "rgb", "value": [0.16, 0.13, 0.1]}}  # fmt: skip
    made = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": bounces + 1, "rr_depth": 1000},
        "sensor": {
            "type": "perspective", "fov": 36, "fov_axis": "x",
            "to_world": place().look_at(origin=[0, -2.7, 1.35], target=[0, 0, 0.86], up=[0, 0, 1]),
            "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}},
            "sampler": {"type": "multijitter"},
        },
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [0.3, 0.35, 0.42]}},
        "lamp": lamp(-0.6, 1.3, 2.3, 0.35, 0.35, [0, 0.2, 0.8], [60, 56, 50]),
        "window": lamp(2.6, -0.6, 1.9, 0.5, 0.8, [0, 0, 0.8], [9, 10.5, 12.5]),
        "floor": {"type": "rectangle", "to_world": place().scale([6, 6, 1]),
                  "bsdf": {"type": "diffuse", "reflectance": checks}},
        "wall": {"type": "rectangle", "bsdf": diffuse(0.55, 0.5, 0.42),
                 "to_world": place().translate([0, 3, 2]).rotate([1, 0, 0], 90).scale([6, 2.2, 1])},
        "picture": box(0.75, 2.97, 1.35, 0.55, 0.02, 0.4, diffuse(0.15, 0.3, 0.5)),
        "door": box(-1.3, 2.97, 0.9, 0.45, 0.02, 0.9, diffuse(0.45, 0.12, 0.08)),
        "top": box(0, 0, 0.765, 0.9, 0.7, 0.015, metal),
        "ball": {"type": "sphere", "center": [-0.3, 0.15, 0.93], "radius": 0.15, "bsdf": diffuse(0.7, 0.2, 0.1)},
        "block": box(0.3, 0.3, 0.88, 0.1, 0.1, 0.1, diffuse(0.15, 0.45, 0.2), turn=30),
        "rod": {"type": "cylinder", "p0": [0.05, -0.2, 0.82], "p1": [0.45, -0.3, 0.82], "radius": 0.04,
                "bsdf": {"type": "twosided", "bsdf": diffuse(0.75, 0.7, 0.6)}},
    }  # fmt: skip
    for x in (-0.8, 0.8):
        for y in (-0.6, 0.6):
            made[f"leg{x}{y}".replace(".", "_")] = box(x, y, 0.375, 0.03, 0.03, 0.375, metal)
    return made


def render(made: dict, samples: int, seed: int, tell=lambda share: None) -> np.ndarray:
    """Linear radiance, float64 (height, width, 3). Pictures whose `seed` differs share no random numbers."""
    loaded, film = mi.load_dict(made), made["sensor"]["film"]
    most = min(SAMPLES_A_PASS, max(1, PATHS_A_PASS // (film["width"] * film["height"])))
    total = np.zeros((film["height"], film["width"], 3))
    for i, first in enumerate(range(0, samples, most)):
        count = min(most, samples - first)
        total += count * np.array(mi.render(loaded, spp=count, seed=(seed << 20) + i), dtype=float)
        tell((first + count) / samples)
    return total / samples


def srgb(linear: np.ndarray) -> np.ndarray:
    """What a screen shows, 0 to 1."""
    x = np.clip(linear, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def psnr(a: np.ndarray, b: np.ndarray) -> list[float]:
    """dB, of R, G, B and of the three together, of what a screen shows."""
    squares = ((srgb(a) - srgb(b)) ** 2).mean(axis=(0, 1))
    return [-10 * math.log10(x) if x > 0 else math.inf for x in (*squares, squares.mean())]


def try_variant(variant: str, bsdf: pathlib.Path) -> None:
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    mi.set_variant(variant)
    render(scene(bsdf, 8, 8, 2), 1, 0)


def choose_variant(bsdf: pathlib.Path) -> str:
    """LLVM's where it renders: some releases of LLVM end the process that tries, so that another one does."""
    trial = multiprocessing.get_context("spawn").Process(target=try_variant, args=("llvm_ad_rgb", bsdf))
    trial.start()
    trial.join()
    if trial.exitcode == 0:
        return "llvm_ad_rgb"
    print("table.py: Mitsuba cannot use this LLVM, its slower variant without is taken; DRJIT_LIBLLVM_PATH may name "
          "another libLLVM.so", file=sys.stderr)  # fmt: skip
    return "scalar_rgb"


class Progress:
    """The share done and the time left: a line that is replaced on a terminal, one a picture elsewhere."""

    def __init__(self, quiet: bool, pictures: int):
        self.quiet, self.pictures, self.begin = quiet, pictures, time.monotonic()
        self.terminal = sys.stderr.isatty()

    def show(self, picture: int, name: str, share: float) -> None:
        if self.quiet or not (self.terminal or share == 1):
            return
        done = (picture + share) / self.pictures
        left = (time.monotonic() - self.begin) * (1 - done) / done
        text = f"{picture + 1} of {self.pictures}: {name}, {100 * share:.0f} %, {left:.0f} s left"
        print(f"\r{text:<78}" if self.terminal else text, end="" if self.terminal else "\n", file=sys.stderr, flush=True)

    def clear(self) -> None:
        if self.terminal and not self.quiet:
            print(f"\r{'':<78}\r", end="", file=sys.stderr, flush=True)


def brdfit(options: argparse.Namespace, *arguments: object) -> str:
    """Runs the program; returns what it prints. Ends with its status where it fails, after what it says."""
    quiet = ["--quiet"] if options.quiet else []
    try:
        done = subprocess.run([options.brdfit, *quiet, *map(str, arguments)], stdout=subprocess.PIPE, text=True)
    except OSError as error:
        sys.exit(f"table.py: {options.brdfit}: {error.strerror}; expected the program brdfit (--brdfit)")
    if done.returncode != 0:
        sys.exit(done.returncode)
    return done.stdout


def materials(options: argparse.Namespace) -> list[dict]:
    """Fits the models; writes FOLDER/NAME.bsdf of the measurement and of each. Returns a row a picture."""
    channels = json.loads(brdfit(options, "info", options.file, "--json"))["channels"]
    if len(channels) not in (1, 3):
        sys.exit(f"table.py: {options.file}: {len(channels)} channels; expected one, or R, G and B")
    options.output.mkdir(parents=True, exist_ok=True)
    fits = json.loads(brdfit(options, "fit", options.file, "-m", options.models, "--lobes", options.lobes, "--metric",
                             options.metric, "--max-theta", options.max_theta, "-o", options.output / "fits", "--json",
                             "--force"))  # fmt: skip
    rows = [{"name": REFERENCE, "source": options.file}, {"name": AGAIN, "source": options.file}]
    rows += [{"name": fit["model"], "source": fit["material_file"], "error": fit["error"][options.metric]}
             for fit in fits]  # fmt: skip
    for row in rows:
        row["bsdf"] = options.output / f"{'measured' if row['name'] == AGAIN else row['name']}.bsdf"
        if row["name"] != AGAIN:
            brdfit(options, "convert", row["source"], row["bsdf"], "--size", NODES)
    return rows


def strip(rows: list[dict]) -> np.ndarray:
    """The measurement, kurt, the best and the worst model beside each other, each once; rows are sorted."""
    fitted = [row for row in rows if row["name"] not in (REFERENCE, AGAIN)]
    chosen = [row for row in rows if row["name"] == REFERENCE]
    chosen += [row for row in fitted if row["name"] == "kurt"]
    chosen += [row for row in (fitted[0], fitted[-1]) if row["name"] not in [other["name"] for other in chosen]]
    print("strip.jpg:", ", ".join(row["name"] for row in chosen))
    gap = np.ones((chosen[0]["picture"].shape[0], 4, 3))
    parts = [part for row in chosen for part in (gap, row["picture"])]
    return np.concatenate(parts[1:], axis=1)


def report(options: argparse.Namespace, rows: list[dict]) -> None:
    rows.sort(key=lambda row: -row["psnr"][3])
    with open(options.output / "psnr.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["model", f"{options.metric}_error", "psnr_r", "psnr_g", "psnr_b", "psnr"])
        table.writerows([row["name"], row.get("error", ""), *row["psnr"]] for row in rows if row["name"] != REFERENCE)
    print(f"{'':<20}{options.metric + ' error':>12}{'R':>8}{'G':>8}{'B':>8}{'PSNR, dB':>10}")
    for row in rows:
        if row["name"] != REFERENCE:
            error = f"{row['error']:.4g}" if "error" in row else ""
            red, green, blue, mean = row["psnr"]
            print(f"{row['name']:<20}{error:>12}{red:8.2f}{green:8.2f}{blue:8.2f}{mean:10.2f}")
    mi.Bitmap(np.rint(255 * srgb(strip(rows))).astype(np.uint8)).write(str(options.output / "strip.jpg"), quality=90)


def parse() -> argparse.Namespace:
    def positive(text: str) -> int:
        if not text.isdigit() or int(text) < 1:
            raise argparse.ArgumentTypeError(f"{text}; expected a whole number of at least 1")
        return int(text)

    def size(text: str) -> tuple[int, int]:
        numbers = text.split("x")
        if len(numbers) != 2 or not all(x.isdigit() and 8 <= int(x) <= 8192 for x in numbers):
            raise argparse.ArgumentTypeError(f"{text}; expected WIDTHxHEIGHT, 8 to 8192 pixels each")
        return int(numbers[0]), int(numbers[1])

    summary, _, details = __doc__.partition("\n\n")
    parser = argparse.ArgumentParser(description=summary, epilog=details,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)  # fmt: skip
    parser.add_argument("file", metavar="FILE", help="measured reflectance, in any format that brdfit reads")
    parser.add_argument("-o", "--output", metavar="FOLDER", type=pathlib.Path, required=True)
    parser.add_argument("-m", "--models", default="all", help="as of brdfit fit (default: all)")
    parser.add_argument("--lobes", type=positive, default=3, help="of each model (default: 3)")
    parser.add_argument("--metric", default="ngan", help="that the fits minimise (default: ngan)")
    parser.add_argument("--max-theta", default="80", help="as of brdfit fit (default: 80)")
    parser.add_argument("--size", type=size, default=(320, 200), help="of a picture (default: 320x200)")
    parser.add_argument("--samples", type=positive, default=256, help="a pixel (default: 256)")
    parser.add_argument("--bounces", type=positive, default=5, help="of light (default: 5)")
    parser.add_argument("--brdfit", default="brdfit", help="the program (default: the one on the path)")
    parser.add_argument("--quiet", action="store_true", help="no progress")
    parser.add_argument("--force", action="store_true", help="write into a folder that is not empty")
    options = parser.parse_args()
    if options.output.exists() and not options.output.is_dir():
        parser.error(f"{options.output}: not a folder")
    if not options.force and options.output.is_dir() and any(options.output.iterdir()):
        parser.error(f"{options.output}: not empty; --force replaces what is there")
    return options


def main() -> None:
    options = parse()
    rows = materials(options)
    mi.set_variant(choose_variant(rows[0]["bsdf"]))
    mi.set_log_level(mi.LogLevel.Error)  # not of a number of samples that its sampler rounds
    progress = Progress(options.quiet, len(rows))
    for i, row in enumerate(rows):
        row["picture"] = render(scene(row["bsdf"], *options.size, options.bounces), options.samples, i,
                                lambda share: progress.show(i, row["name"], share))  # fmt: skip
        row["psnr"] = psnr(rows[0]["picture"], row["picture"])
        name = row["name"].replace(" ", "-") + ".exr"
        mi.Bitmap(row["picture"].astype(np.float32)).write(str(options.output / name))
    progress.clear()
    report(options, rows)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit(130)
