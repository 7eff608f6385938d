"""Fits several models to a measured file and compares what they make of it.

python fit_and_compare.py [FILE]"""

from __future__ import annotations

import sys

import numpy as np

import brdfit


def synthesised() -> brdfit.Samples:
    """Measurements of a plastic, where no file is given: 5000 pairs of directions, noise of 1 %."""
    rng = np.random.default_rng(1)
    wi, wo = rng.normal(size=(2, 5000, 3))
    for vectors in (wi, wo):
        vectors[:, 2] = np.abs(vectors[:, 2]) + 0.05
        vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    plastic = brdfit.Material(
        diffuse=[0.3, 0.1, 0.1], lobes=[{"model": "ggx", "ks": 0.9, "f0": 0.05, "a": 0.2}]
    )
    values = plastic.eval(wi, wo) * rng.normal(1, 0.01, size=(5000, 1))
    return brdfit.Samples(wi, wo, values, isotropic=True)


def main(file: str | None = None) -> brdfit.Fit:
    samples = brdfit.read(file) if file else synthesised()
    print(samples)
    fits = brdfit.fit(samples, ["lambert", "ward", "cook-torrance", "ggx"])
    for fit in sorted(fits, key=lambda fit: fit.error):
        print(f"{fit.model:15} {fit.error:.5f}  {', '.join(fit.remarks)}")
    best = fits.best
    for name, value in best.parameters.items():
        print(f"{name:12} {value:.4f} +- {best.standard_errors[name]:.1g}")

    # How far the best is from the data near the mirror direction and elsewhere.
    h = samples.wi + samples.wo
    near = h[:, 2] / np.linalg.norm(h, axis=1) > np.cos(np.radians(20))
    difference = np.abs(best.material.eval(samples.wi, samples.wo) - samples.values).mean(axis=1)
    print(f"mean difference {difference[near].mean():.4f} near the peak, {difference[~near].mean():.4f} elsewhere")
    best.material.save("best.json")
    return best


if __name__ == "__main__":
    main(*sys.argv[1:2])
