"""Bad input: an exception that names the argument and says what was expected; never a crash."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import brdfit
from conftest import random_pairs

UP = np.array([0.0, 0.0, 1.0])
LAMBERT = brdfit.Material(0.5)
WI, WO = random_pairs(10)


def with_element(array, index, value):
    array = np.array(array, dtype=np.float64)
    array[index] = value
    return array


@pytest.mark.parametrize("call", ["eval", "pdf"])
@pytest.mark.parametrize(
    "wi, wo, message",
    [
        (np.ones((5, 2)), UP, r"wi: shape \(5, 2\)"),
        (UP, np.ones(3), r"wo is \(1, 1, 1\); expected a unit vector"),
        (with_element(WI, (4, 1), np.nan), WO, r"wi\[4\].*unit"),
        (WI, with_element(WO, (7, 2), np.inf), r"wo\[7\].*unit"),
        (WI, np.zeros(3), r"wo.*unit"),
        (WI.reshape(2, 5, 3), with_element(WO, (7, 2), 5).reshape(2, 5, 3), r"wo\[1, 2\].*unit"),
        (WI, WO[:4], "broadcast"),
        (1.0, UP, r"wi: shape \(\)"),
        ("up", UP, "wi: <U2|wi: .*expected numbers"),
        (UP, [None, 0, 1], "wo: object"),
        (UP.astype(complex), UP, "wi: complex128"),
        (UP.astype(object), UP, "wi: object"),
        ([[0, 0, 1], [0, 1]], UP, "wi: no array"),
        (np.array(["a", "b", "c"]), UP, "wi: <U1"),
        (UP.astype(np.longdouble), UP, "wi: float128|wi: longdouble"),
    ],
)
def test_directions(call, wi, wo, message):
    with pytest.raises(brdfit.InputError, match=message):
        getattr(LAMBERT, call)(wi, wo)


@pytest.mark.parametrize(
    "wo, n, options, message",
    [
        ([0, 0, -1], 5, {}, "wo is not above the horizon"),
        ([[0, 0, 1], [1, 0, 0]], 5, {}, r"wo\[1\] is not above the horizon"),
        ([0, 0, 2], 5, {}, "wo.*unit"),
        (UP, 0, {}, "n: 0; expected a whole number from 1"),
        (UP, -3, {}, "n: -3"),
        (UP, 10**12, {}, "n: 1000000000000 of each"),
        (UP, 10**30, {}, "n: .*whole number"),
        (UP, 1.5, {}, "n: 1.5"),
        (UP, True, {}, "n: True"),
        (UP, 5, {"seed": -1}, "seed: -1"),
        (UP, 5, {"seed": 2**64}, "seed"),
        (UP, 5, {"sequence": "halton"}, "sequence: 'halton'"),
        (UP, 5, {"device": "no such device"}, "no such device"),
        (UP, 5, {"device": 99}, "99"),
        (UP, 5, {"device": 1.5}, "device: 1.5"),
    ],
)
def test_sampling(wo, n, options, message):
    with pytest.raises(brdfit.InputError, match=message):
        LAMBERT.sample(wo, n, **options)


@pytest.mark.parametrize(
    "theta, phi, tolerance, message",
    [
        (-0.1, 0, 1e-4, "theta"),
        (2, 0, 1e-4, "theta"),
        (np.nan, 0, 1e-4, "theta"),
        (0.5, np.inf, 1e-4, "phi"),
        ([0.1, 0.2], [0.1, 0.2, 0.3], 1e-4, "theta and phi"),
        (0.5, 0, 0, "tolerance"),
        (0.5, 0, 1e-9, "tolerance"),
        (0.5, 0, "small", "tolerance: 'small'"),
        (0.5, 0, np.nan, "tolerance"),
    ],
)
def test_albedos(theta, phi, tolerance, message):
    with pytest.raises(brdfit.InputError, match=message):
        LAMBERT.albedo(theta, phi, tolerance)


LOBE = {"model": "ggx", "ks": 0.5, "f0": 0.04, "a": 0.1}


@pytest.mark.parametrize(
    "diffuse, lobes, options, message",
    [
        (-1, [], {}, "kd"),
        (np.nan, [], {}, "kd|NaN"),
        ([0.1, 0.2], [{**LOBE, "ks": [1, 2, 3]}], {}, r"lobes\[0\].ks: shape \(3,\)"),
        ({"model": "lambert"}, [], {}, "kd"),
        ({"model": "oren-nayar", "kd": 1}, [], {}, "oren-nayar"),
        ({"model": "lambert", "kd": 1, "colour": "red"}, [], {}, "colour"),
        ({"model": "kurt-coupled", "kd": 1}, [LOBE], {}, "kurt"),
        (0.1, [{**LOBE, "a": 5}], {}, r"lobes\[0\].a"),
        (0.1, [{**LOBE, "a": "rough"}], {}, r"lobes\[0\].a"),
        (0.1, [{"model": "ggx", "ks": 0.5, "f0": 0.04}], {}, "a"),
        (0.1, [{**LOBE, "m": 0.1}], {}, "m"),
        (0.1, [{"ks": 0.5}], {}, "model"),
        (0.1, [LOBE] * 5, {}, "5 lobes"),
        (0.1, LOBE, {}, "lobes: expected a sequence"),
        (0.1, ["ggx"], {}, "lobes: expected a sequence"),
        (0.1, [], {"channels": []}, "channels"),
        (0.1, [], {"channels": ["R", "R"]}, "channels"),
        (0.1, [{**LOBE, "ks": {1, 2}}], {}, "ks"),
        (0.1, [{**LOBE, "a": object()}], {}, "material: object"),
    ],
)
def test_materials(diffuse, lobes, options, message):
    with pytest.raises(brdfit.InputError, match=message):
        brdfit.Material(diffuse, lobes, **options)


@pytest.mark.parametrize("data", [None, [], "text", {}, {"brdfit": 2}, {"brdfit": 1, "channels": ["R"]}])
def test_dicts_of_materials(data):
    with pytest.raises(brdfit.InputError):
        brdfit.Material.from_dict(data)


VALUES = np.ones((10, 3))


@pytest.mark.parametrize(
    "arguments, message",
    [
        ((WI, WO, VALUES[:5]), "values: 5 rows; expected 10"),
        ((WI, WO[:5], VALUES), "wo: 5 rows"),
        ((WI, WO, VALUES, np.ones(3)), "weights: 3 rows"),
        ((WI, WO, VALUES, np.ones((10, 2))), "weights: shape"),
        ((WI, WO, VALUES, -np.ones(10)), r"weights\[0\] is -1"),
        ((WI, WO, with_element(VALUES, (3, 1), np.nan)), r"values\[3, 1\] is nan"),
        ((WI, WO, with_element(VALUES, (3, 1), 1e300)), r"values\[3, 1\]"),
        ((WI, -WO, VALUES), r"wo\[0\] is below the horizon"),
        ((2 * WI, WO, VALUES), r"wi\[0\].*unit"),
        ((WI, WO, VALUES[:, :0]), "0 channels"),
        ((WI[:0], WO[:0], VALUES[:0]), "no samples"),
        ((WI, WO, VALUES.reshape(10, 3, 1)), "values: shape"),
        ((WI[0], WO, VALUES), r"wi: shape \(3,\)"),
        ((WI, WO, VALUES, None, ["R", "G"]), "channels: 2 names; expected 3"),
        ((WI, WO, VALUES, None, ["R", "R", "B"]), "channels: a name is given twice"),
        ((WI, WO, VALUES, None, ["R", "G", "a,b"]), "channels: 'a,b'"),
        ((WI, WO, VALUES, None, "RGB"), "channels: 'RGB'"),
    ],
)
def test_samples(arguments, message):
    with pytest.raises(brdfit.InputError, match=message):
        brdfit.Samples(*arguments)


@pytest.mark.parametrize(
    "models, lobes, options, message",
    [
        ("phong", None, {}, "phong"),
        ([], None, {}, "models: \\[\\]"),
        ([1], None, {}, "models"),
        ("ward", 5, {}, "lobes: 5"),
        ("ward", "2", {}, "lobes: '2'"),
        ("ward", None, {"metric": "l3"}, "l3"),
        ("ward", None, {"max_theta": 0}, "max_theta"),
        ("ward", None, {"max_theta": "all"}, "max_theta: 'all'"),
        ("ward", None, {"diffuse": "matt"}, "^diffuse matt"),
        ("ward", None, {"fix": {"f0": 0.1}}, "f0"),
        ("ward", None, {"fix": {"m": "thin"}}, "fix\\['m'\\]"),
        ("ward", None, {"fix": {"m": 0.1}, "bounds": {"m": (0.2, 0.3)}}, "m"),
        ("ward", None, {"bounds": {"m": 0.1}}, "bounds\\['m'\\]"),
        ("ward", None, {"bounds": {"m": (0.3, 0.1)}}, "m"),
        ("ward", None, {"bounds": {"m": (np.nan, 0.1)}}, "bounds"),
        ("ward", None, {"algorithm": "newton"}, "newton"),
        ("ward", None, {"starts": -1}, "starts: -1"),
        ("ward", None, {"max_evaluations": 0}, "max_evaluations: 0"),
        ("ward", None, {"start": "plastic"}, "start: str"),
        ("ward", None, {"start": brdfit.Material(0.5)}, "start"),
        ("microfacet", None, {}, "microfacet"),
    ],
)
def test_fits(models, lobes, options, message, measured):
    with pytest.raises(brdfit.InputError, match=message):
        brdfit.fit(measured, models, lobes, **options)


def test_samples_that_no_fit_can_use(plastic):
    wi, wo = random_pairs(10)
    grazing = np.broadcast_to([np.cos(0.01), 0, np.sin(0.01)], (10, 3))
    with pytest.raises(brdfit.InputError, match="samples"):
        brdfit.fit(brdfit.Samples(grazing, grazing, np.ones(10)), "ward")
    with pytest.raises(brdfit.InputError, match="weights"):
        brdfit.fit(brdfit.Samples(wi, wo, np.ones(10), np.zeros(10)), "ward")
    with pytest.raises(brdfit.InputError, match="samples: 1 channels; expected 3"):
        plastic.errors(brdfit.Samples(wi, wo, np.ones(10)))
    with pytest.raises(brdfit.InputError, match="samples: ndarray"):
        plastic.errors(wi)


@pytest.mark.parametrize(
    "what, options, message",
    [
        ("no-such", {}, "no-such.*presets"),
        ("osl", {"model": "phong"}, "phong"),
        ("osl", {"model": "lambert"}, "lambert"),
        ("osl", {"tolerance": -1}, "tolerance"),
        ("osl", {"size": 1}, "size"),
        ("osl", {"encoding": "text"}, "encoding: 'text'"),
        ("osl", {"parameters": {"alpha": 1}}, "alpha"),
        ("albedo", {"cos_theta": 4, "roughness": "many"}, "roughness"),
        ("albedo", {"cos_theta": 4}, "roughness"),
        ("whiteness", {"cos_theta": 4, "roughness": 4}, "whiteness"),
        ({"axes": []}, {}, "axes"),
        ({"axes": []}, {"roughness": 4}, "preset_or_spec"),
        ("missing.json", {}, "missing.json"),
    ],
)
def test_tables(what, options, message):
    with pytest.raises(brdfit.InputError, match=message):
        brdfit.table(what, **options)


@pytest.mark.parametrize(
    "spec, options, message",
    [
        ({}, {}, "distribution"),
        ({"distribution": "gaussian", "sigma_x": -1, "sigma_y": 1}, {}, "sigma_x"),
        ({"distribution": "gaussian", "sigma_x": 0.1, "sigma_y": 0.1}, {"points": 3}, "points: 3"),
        ({"distribution": "gaussian", "sigma_x": 0.1, "sigma_y": 0.2}, {"lambertian": True}, "ambertian"),
        ("missing.json", {}, "missing.json"),
    ],
)
def test_distributions(spec, options, message):
    with pytest.raises(brdfit.InputError, match=message):
        brdfit.generate(spec, **options)


@pytest.mark.parametrize("call", [brdfit.read, brdfit.Material.load, brdfit.results, brdfit.tasks, brdfit.fit])
def test_missing_and_broken_files(call, tmp_path):
    if call is brdfit.results:
        pytest.importorskip("pandas")
    with pytest.raises(brdfit.InputError, match="missing"):
        call(tmp_path / "missing")
    (tmp_path / "broken").write_bytes(bytes(range(256)))
    with pytest.raises(brdfit.InputError, match="broken"):
        call(tmp_path / "broken")


@pytest.mark.parametrize("ending", [".txt", ".png", ""])
def test_unknown_endings(ending, measured, plastic, tmp_path):
    for write in (measured.save, plastic.export, brdfit.table("osl", tolerance=1e-2, size=4).save):
        with pytest.raises(brdfit.InputError, match="ending"):
            write(tmp_path / f"out{ending}")
    assert not list(tmp_path.iterdir())


def test_input_errors_are_value_errors():
    assert issubclass(brdfit.InputError, ValueError) and issubclass(brdfit.DeviceError, RuntimeError)


def test_no_device_names_the_package(tmp_path):
    """The loader of OpenCL finds drivers in OCL_ICD_VENDORS."""
    script = (
        "import brdfit\n"
        "try:\n    brdfit.Material(0.5).eval([0, 0, 1], [0, 0, 1])\n"
        "except brdfit.DeviceError as error:\n    print(error)\n"
    )
    (tmp_path / "none").mkdir()
    environment = {**os.environ, "OCL_ICD_VENDORS": str(tmp_path / "none")}
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env=environment)
    assert "pocl-opencl-icd" in done.stdout, done.stderr


def test_devices_that_fail():
    """A driver that has no memory, or runs no kernel; each call says so, and the next may be made."""
    faulty = os.environ.get("BRDFIT_FAULTY_OPENCL")
    if not faulty:
        pytest.skip("BRDFIT_FAULTY_OPENCL names no driver that fails; ctest does")
    script = """
import brdfit
m = brdfit.Material(0.5, [{"model": "ggx", "ks": 0.5, "f0": 0.04, "a": 0.1}])
s = brdfit.Samples([[0, 0, 1]] * 9, [[0.6, 0, 0.8]] * 9, [[1, 1, 1]] * 9)
up = [0, 0, 1]
calls = [
    lambda: m.eval(up, up), lambda: m.pdf(up, up), lambda: m.sample(up, 5), lambda: m.albedo(0.5),
    lambda: m.render(size=8, samples=1), lambda: m.export("m.bsdf"), lambda: m.errors(s),
    lambda: brdfit.fit(s, ["ward", "ggx"]), lambda: brdfit.compare(m, m), lambda: brdfit.table("osl", tolerance=1e-2, size=4),
    lambda: brdfit.generate({"distribution": "gaussian", "sigma_x": 0.2, "sigma_y": 0.2}, points=16),
]
for i, call in enumerate(calls):
    try:
        call()
        print(i, "did it")
    except brdfit.DeviceError as error:
        assert "CL_" in str(error), error
print(len(brdfit.devices()) > 0)
"""
    preload = " ".join(filter(None, [os.environ.get("LD_PRELOAD"), faulty]))
    for fault in ("FAULTY_BUFFERS", "FAULTY_KERNELS"):
        environment = {**os.environ, "LD_PRELOAD": preload, fault: "0"}
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env=environment)
        assert (done.returncode, done.stdout) == (0, "True\n"), (fault, done.stdout, done.stderr)


def test_a_material_made_anew_while_in_use():
    """Another __init__ is the only way to change one; what is under way goes on with what it began with."""
    wi, wo = random_pairs(200000)
    material = brdfit.Material(0.5)
    old, new = material.eval(wi, wo), 0.5 * material.eval(wi, wo)
    with ThreadPoolExecutor(2) as pool:
        found = [pool.submit(material.eval, wi, wo) for _ in range(8)]
        for kd in [0.25, 0.5] * 8:
            material.__init__(kd)
        for future in found:
            values = future.result()
            assert np.array_equal(values, old) or np.allclose(values, new, rtol=1e-6)


def test_arrays_changed_while_in_use():
    """Whatever another thread writes meanwhile, an answer or an InputError comes of it; none resizes them."""
    wi, wo = random_pairs(500000)
    with ThreadPoolExecutor(1) as pool:
        found = pool.submit(LAMBERT.eval, wi, wo)
        while not found.done():
            wi[::7] = np.nan
            with pytest.raises(ValueError, match="resize"):
                wi.resize((10, 3))
            wi[::7] = UP
        try:
            assert found.result().shape == (500000, 3)
        except brdfit.InputError as error:
            assert str(error).startswith("wi[")


def test_no_leaks():
    """nanobind tells of what is left when Python ends."""
    script = (
        "import numpy as np, brdfit\n"
        "m = brdfit.Material(0.5)\n"
        "f = m.eval(np.broadcast_to([0, 0, 1.0], (100, 3)), [0, 0, 1])\n"
        "s = brdfit.Samples(f * 0 + [0, 0, 1], f * 0 + [0, 0, 1], f)\n"
        "wi = s.wi\n"
        "told = []\n"
        "fits = brdfit.fit(s, ['lambert', 'ward'], progress=lambda share, what: told.append(what))\n"
        "kept = [m.sample([0, 0, 1], 9), m.albedo(0.5), m.render(size=4, samples=1), brdfit.compare(m, s),\n"
        "        brdfit.table('osl', tolerance=1e-2, size=4).axes, brdfit.devices(), brdfit.models()[3].isotropic,\n"
        "        brdfit.generate({'distribution': 'gaussian', 'sigma_x': 0.2, 'sigma_y': 0.2}, points=16).g]\n"
        "def fail(share, what): raise KeyError\n"
        "for call in (lambda: m.eval([0, 0, 2], [0, 0, 1]), lambda: brdfit.fit(s, 'ggx', starts=10**5, progress=fail),\n"
        "             lambda: brdfit.read('missing'), lambda: m.eval([0, 0, 1], [0, 0, 1], device='none')):\n"
        "    try:\n        call()\n        assert False\n"
        "    except (brdfit.InputError, brdfit.DeviceError, KeyError) as error:\n        kept.append(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
