"""Comparisons of materials and measurements, and reports of fits, against the program's."""

import json

import numpy as np
import pytest

import brdfit
from conftest import command, random_pairs


@pytest.fixture(scope="module")
def files(plastic, measured, measured_file, tmp_path_factory):
    """What is compared, by a name: as Python has it, and the program's file."""
    folder = tmp_path_factory.mktemp("compared")
    other = brdfit.Material(diffuse=0.2, lobes=[{"model": "ggx", "ks": 0.5, "f0": 0.04, "ax": 0.1, "ay": 0.2}])
    for name, material in (("plastic", plastic), ("other", other)):
        material.save(folder / f"{name}.json")
    command("synth", folder / "plastic.json", folder / "plastic.binary")
    return {
        "plastic": (plastic, folder / "plastic.json"),
        "other": (other, folder / "other.json"),
        "scattered": (measured, measured_file),
        "merl": (brdfit.read(folder / "plastic.binary"), folder / "plastic.binary"),
    }


@pytest.mark.parametrize(
    "a, b, options, arguments",
    [
        ("plastic", "other", [], {}),
        ("scattered", "plastic", [], {}),
        ("other", "scattered", ["--max-theta", "60"], {"max_theta": 60}),
        ("scattered", "merl", ["--worst", "2"], {"worst": 2}),
        ("merl", "other", ["--worst", "0"], {"worst": 0}),
    ],
)
def test_comparisons_are_the_programs(a, b, options, arguments, files):
    theirs = json.loads(command("compare", files[a][1], files[b][1], "--json", *options))
    for name, (_, path) in (("a", files[a]), ("b", files[b])):
        assert theirs.pop(name) == str(path)
        theirs["at"] = theirs["at"].replace(str(path), name)
    assert brdfit.compare(files[a][0], files[b][0], **arguments) == theirs


def test_samples_of_arrays_are_compared_too(plastic):
    wi, wo = random_pairs(500, seed=6)
    samples = brdfit.Samples(wi, wo, plastic.eval(wi, wo), isotropic=True)
    same, different = brdfit.compare(samples, plastic), brdfit.compare(samples, brdfit.Material(0.3))
    assert same["errors"]["ngan"] < 1e-6 < different["errors"]["ngan"]
    assert same["channels"] == ["R", "G", "B"] and len(same["worst"]) == 5
    assert brdfit.compare(plastic, samples)["samples"] == same["samples"]


@pytest.mark.parametrize(
    "a, b, options, message",
    [
        (brdfit.Material(0.5), "plastic.json", {}, "b: str"),
        (None, brdfit.Material(0.5), {}, "a: NoneType"),
        (brdfit.Material(0.5), brdfit.Material(0.5), {"max_theta": 91}, "max_theta: 91"),
        (brdfit.Material(0.5), brdfit.Material(0.5), {"worst": -1}, "worst: -1"),
        (brdfit.Material(0.5), brdfit.Material(0.5, channels=["a", "b"]), {}, "a has the channels R, G, B and b"),
        (brdfit.Samples([[1, 0, 0]], [[1, 0, 0]], np.ones((1, 3))), brdfit.Material(0.5), {}, "samples"),
    ],
)
def test_bad_input(a, b, options, message):
    with pytest.raises(brdfit.InputError, match=message):
        brdfit.compare(a, b, **options)


@pytest.fixture(scope="module")
def fits(measured_file, tmp_path_factory):
    folder = tmp_path_factory.mktemp("fits")
    command("fit", measured_file, "-m", "lambert,ward,kurt", "-o", folder, "--json")
    return folder


def test_a_report_is_the_programs(fits, tmp_path):
    options = ["--models", "ward,kurt", "--size", 16, "--samples", 4]
    command("report", fits, "-o", tmp_path / "theirs.html", *options)
    brdfit.report(fits, tmp_path / "ours.html", models=["ward", "kurt"], size=16, samples=4)
    assert (tmp_path / "ours.html").read_bytes() == (tmp_path / "theirs.html").read_bytes()
    brdfit.report(fits, tmp_path / "ours.html", materials=["pl*"], size=0)
    assert (tmp_path / "ours.html").read_bytes() != (tmp_path / "theirs.html").read_bytes()


@pytest.mark.parametrize(
    "options, message",
    [
        ({"path": "report.pdf"}, "report.pdf: unknown ending"),
        ({"models": "ward"}, "models: 'ward'"),
        ({"models": ["phong"]}, "phong"),
        ({"materials": ["no-such"]}, "no-such"),
        ({"model": "phong"}, "phong"),
        ({"metric": "l3"}, "l3"),
        ({"size": 2000}, "size: 2000"),
        ({"samples": 0}, "samples: 0"),
        ({"folder": "missing"}, "missing"),
    ],
)
def test_reports_that_cannot_be(options, message, fits, tmp_path):
    options = {"folder": fits, "path": tmp_path / "r.html", **options}
    with pytest.raises(brdfit.InputError, match=message):
        brdfit.report(**options)
    assert not list(tmp_path.iterdir())
