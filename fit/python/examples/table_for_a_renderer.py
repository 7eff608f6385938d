"""Tabulates the albedo of a model for multiple scattering in a renderer, and checks it by sampling.

python table_for_a_renderer.py [MODEL]"""

from __future__ import annotations

import sys

import numpy as np

import brdfit


def main(model: str = "ggx") -> brdfit.Table:
    table = brdfit.table("albedo", model=model, tolerance=1e-3, cos_theta=16, roughness={"size": 8, "range": [0.1, 1]})
    print(table)
    print(table.provenance)
    mu, roughness = table.axes[0].values, table.axes[1].values

    # One entry of it by 65536 samples: the mean weight is the albedo.
    i, j = 8, 5
    wo = [np.sqrt(1 - mu[i] ** 2), 0, mu[i]]
    parameter = next(p.name for p in find(model).isotropic if p.name not in ("f0", "alpha"))
    shape = {p.name: p.default for p in find(model).isotropic} | {parameter: roughness[j]}
    if "f0" in shape:
        shape["f0"] = 1.0
    _, _, weight = brdfit.Material(0, [{"model": model, "ks": 1, **shape}]).sample(wo, 1 << 16)
    print(f"cos theta {mu[i]:.3f}, roughness {roughness[j]:.3f}: {table.values[i, j, 0]:.4f}, sampled {weight.mean():.4f}")
    table.save(f"{model}_albedo.exr")
    table.save(f"{model}_albedo.h")
    return table


def find(name: str) -> brdfit.Model:
    return next(model for model in brdfit.models() if model.name == name)


if __name__ == "__main__":
    main(*sys.argv[1:2])
