"""What the tests of the Python module share: the program they compare with, materials, directions.

BRDFIT_PROGRAM names the program; ctest sets it and the path of the package."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import brdfit

PROGRAM = os.environ.get("BRDFIT_PROGRAM", "brdfit")
ROOT = Path(__file__).resolve().parents[2]


def command(*arguments, status=0):
    """Runs the program; returns its standard output."""
    done = subprocess.run([PROGRAM, "--quiet", *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == status, done.stderr
    return done.stdout


def model_names():
    return [model.name for model in brdfit.models() if not model.table]


def typical(model, isotropic):
    """A material with a lobe of the model, at the values that the catalogue calls typical."""
    parameters = model.isotropic if isotropic else model.anisotropic
    values = {p.name: p.default for p in parameters}
    if not isotropic and len(parameters) > len(model.isotropic):
        roughness = [p for p in parameters if p.name not in {q.name for q in model.isotropic}]
        values[roughness[0].name] = 0.7 * roughness[0].default  # unlike the other
    lobe = {"ks": [0.5, 0.3, 0.2], **values}
    if model.kind == "lobe":
        return brdfit.Material(diffuse=[0.1, 0.2, 0.3], lobes=[{"model": model.name, **lobe}])
    diffuse = {"model": model.name, "kd": [0.1, 0.2, 0.3]}
    return brdfit.Material(diffuse, [{"model": "kurt", **lobe}] if values else [])


def material_of(name, isotropic):
    return typical({model.name: model for model in brdfit.models()}[name], isotropic)


def random_pairs(count, seed=1, below=False, dtype=np.float64):
    """Unit vectors (count, 3), (count, 3), above the horizon unless some may be below."""
    rng = np.random.default_rng(seed)
    vectors = rng.normal(size=(2, count, 3))
    if not below:
        vectors[..., 2] = np.abs(vectors[..., 2]) + 1e-3
    vectors /= np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors.astype(dtype)


@pytest.fixture(scope="session")
def pairs():
    """One array of pairs for all comparisons, some of them below the horizon."""
    return random_pairs(3000, below=True)


@pytest.fixture(scope="session")
def pairs_file(pairs, tmp_path_factory):
    path = tmp_path_factory.mktemp("pairs") / "pairs.npy"
    np.save(path, np.concatenate(list(pairs), axis=1))
    return path


@pytest.fixture(scope="session")
def plastic():
    return brdfit.Material(
        diffuse=[0.3, 0.2, 0.1],
        lobes=[{"model": "kurt", "ks": [0.6, 0.6, 0.5], "f0": 0.05, "m": 0.15, "alpha": 0.1}],
    )


@pytest.fixture(scope="session")
def measured_file(plastic, tmp_path_factory):
    """Scattered measurements of plastic, 4000 of them, in a file."""
    folder = tmp_path_factory.mktemp("measured")
    plastic.save(folder / "plastic.json")
    path = folder / "plastic.csv"
    command("synth", folder / "plastic.json", path, "--directions", 4000, "--noise", 0.01, "--seed", 3)
    return path


@pytest.fixture(scope="session")
def measured(measured_file):
    return brdfit.read(measured_file)


def columns(path):
    """A .npy or .csv that the program wrote, as float64, and for a .csv the names of its columns."""
    if str(path).endswith(".npy"):
        return np.load(path)
    with open(path, encoding="utf-8") as file:
        lines = [line for line in file if not line.startswith("#")]
    return lines[0].strip().split(","), np.array([[float(x) for x in line.split(",")] for line in lines[1:]])


def without_times(record):
    """A material's dict without what differs from run to run."""
    record = json.loads(json.dumps(record))
    record.get("fit", {}).pop("seconds", None)
    return record
