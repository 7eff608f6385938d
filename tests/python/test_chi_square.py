"""What sample draws against what pdf says, by Mitsuba's own chi-square test, where Mitsuba and an LLVM are installed
that compiles for it."""

import glob
import os
import re

import numpy as np
import pytest

import brdfit
from conftest import material_of, model_names

LEAST_LLVM = 17  # older ones abort the process: they have no instruction for what Dr.Jit's minimum is


def usable_llvm():
    """The newest LLVM that will do, by its name alone; None where there is none."""
    named = os.environ.get("DRJIT_LIBLLVM_PATH")
    found = []
    for path in [named] if named else glob.glob("/usr/lib*/libLLVM*.so*") + glob.glob("/usr/lib/*/libLLVM*.so*"):
        version = re.search(r"libLLVM(?:-|\.so\.)(\d+)", os.path.basename(os.path.realpath(path)))
        if version and int(version[1]) >= LEAST_LLVM:
            found.append((int(version[1]), path))
    return max(found)[1] if found else None


LLVM = usable_llvm()
if LLVM is None:
    pytest.skip(f"no LLVM from {LEAST_LLVM} on for Mitsuba; Debian's libllvm19 is one", allow_module_level=True)
os.environ["DRJIT_LIBLLVM_PATH"] = LLVM
mi = pytest.importorskip("mitsuba")

SAMPLES = 1_000_000
ELEVATIONS = (10, 55, 80)  # of the viewer, from the normal, degrees; materials are isotropic for the first alone
TABULATED = ("microfacet", "microfacet-lambertian")
# How many tests there are, one in a hundred of which chance may reject.
CASES = len(ELEVATIONS) * (len(model_names()) + len(TABULATED))


@pytest.fixture(scope="module")
def variant():
    mi.set_variant("llvm_ad_rgb")
    yield
    mi.set_variant("scalar_rgb")


def viewer(elevation):
    theta, phi = np.radians([elevation, 35])
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def agree(drawn, density, wo):
    """Whether what `drawn` samples for wo follows the density of `density`, and what the test says of it."""

    def sample(uniforms):
        wi, pdf, _ = drawn.sample(wo, uniforms.shape[1], seed=1, sequence="philox")
        directions = mi.Vector3f(*(mi.Float(np.ascontiguousarray(wi[:, axis])) for axis in range(3)))
        return directions, mi.Float((pdf > 0).astype(np.float32))  # rejected samples count nowhere

    def pdf(directions):
        wi = np.array(directions, dtype=np.float64).T
        return mi.Float(density.pdf(wi / np.linalg.norm(wi, axis=1, keepdims=True), wo))

    test = mi.chi2.ChiSquareTest(mi.chi2.SphericalDomain(), sample, pdf, sample_count=SAMPLES, ires=8)
    return test.run(significance_level=0.01, test_count=CASES, quiet=True), test.messages


@pytest.mark.parametrize("elevation", ELEVATIONS)
@pytest.mark.parametrize("name", model_names())
def test_samples_follow_the_density(name, elevation, variant):
    material = material_of(name, elevation == ELEVATIONS[0])
    accepted, messages = agree(material, material, viewer(elevation))
    assert accepted, messages


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """A folder with a table of each kind."""
    folder = tmp_path_factory.mktemp("tables")
    brdfit.generate({"distribution": "gaussian", "sigma_x": 0.2, "sigma_y": 0.4}, points=64).save(folder / "microfacet.exr")
    isotropic = {"distribution": "gaussian", "sigma_x": 0.3, "sigma_y": 0.3}
    brdfit.generate(isotropic, points=32, lambertian=True).save(folder / "microfacet-lambertian.exr")
    return folder


@pytest.mark.parametrize("elevation", ELEVATIONS)
@pytest.mark.parametrize("name", TABULATED)
def test_samples_of_tables_follow_the_density(name, elevation, tables, variant):
    lobe = {"model": name, "ks": [0.7], "table": f"{name}.exr", **({"f0": 0.5} if name == "microfacet" else {})}
    parts = {"diffuse": {"model": "lambert", "kd": [0.2]}, "lobes": [lobe]}
    material = brdfit.Material.from_dict({"brdfit": 1, "channels": ["R"], **parts}, folder=tables)
    accepted, messages = agree(material, material, viewer(elevation))
    assert accepted, messages


def test_another_density_is_rejected(variant):
    drawn = brdfit.Material(0.1, [{"model": "ggx", "ks": 0.5, "f0": 0.5, "a": 0.2}])
    density = brdfit.Material(0.1, [{"model": "ggx", "ks": 0.5, "f0": 0.5, "a": 0.21}])
    accepted, messages = agree(drawn, density, viewer(55))
    assert not accepted and "Rejected" in messages, messages
