"""The package as a whole: its types, its names, the examples of its chapter."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import brdfit
from conftest import ROOT, command, typical

EXAMPLES = ROOT / "fit" / "python" / "examples"


def test_types(tmp_path):
    pytest.importorskip("mypy")
    package = Path(brdfit.__file__).parent
    assert (package / "_brdfit.pyi").exists() and (package / "py.typed").exists()
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--config-file", ROOT / "pyproject.toml", "--cache-dir", tmp_path,
         package, *sorted(EXAMPLES.glob("*.py"))],
        capture_output=True, text=True, cwd=package.parent, env={**os.environ, "MYPYPATH": str(package.parent)},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


def test_everything_public_says_what_it_is():
    for name in brdfit.__all__:
        thing = getattr(brdfit, name)
        assert thing.__doc__, name
        if isinstance(thing, type) and thing.__module__.startswith("brdfit"):
            for member, value in vars(thing).items():
                if not member.startswith("_") and (callable(value) or isinstance(value, (property, classmethod))):
                    assert value.__doc__, f"{name}.{member}"


def test_eval_says_first_that_the_cosine_is_not_in_it():
    for owner in (brdfit.Material, brdfit.Samples):
        assert "without the cosine" in owner.eval.__doc__.splitlines()[0]


def test_the_version_is_the_programs():
    assert command("--version").split()[-1] == brdfit.__version__


def test_models_are_those_of_the_catalogue():
    import json

    theirs = {model["name"]: model for model in json.loads(command("models", "--json"))}
    assert [model.name for model in brdfit.models()] == list(theirs)
    for model in brdfit.models():
        listed = theirs[model.name]
        for key in ("kind", "shape", "equation", "reciprocal", "conserves_energy", "table"):
            assert getattr(model, key) == listed[key]
        for form in ("isotropic", "anisotropic"):
            assert [(p.name, p.lower, p.upper, p.default) for p in getattr(model, form)] == [
                (p["name"], p["lower"], p["upper"], p["default"]) for p in listed[form]
            ]


def test_devices_are_the_programs():
    import json

    theirs = json.loads(command("devices", "--json"))
    assert [(d.index, d.name, d.platform, d.driver) for d in brdfit.devices()] == [
        (d["index"], d["name"], d["platform"], d["driver"]) for d in theirs
    ]
    material = typical(brdfit.models()[1], True)
    expected = material.eval([0, 0, 1], [0, 0, 1])
    device = brdfit.devices()[[d["default"] for d in theirs].index(True)]
    for wish in (device, device.index, np.int64(device.index), device.name):
        np.testing.assert_array_equal(material.eval([0, 0, 1], [0, 0, 1], device=wish), expected)


@pytest.mark.parametrize(
    "name, needs, arguments",
    [
        ("fit_and_compare", [], []),
        ("database_to_frame", ["pandas"], ["FILES"]),
        ("table_for_a_renderer", [], []),
        ("material_in_mitsuba", ["mitsuba"], []),
    ],
)
def test_examples(name, needs, arguments, measured_file, tmp_path):
    for package in needs:
        pytest.importorskip(package)
    arguments = [str(measured_file.parent) if a == "FILES" else a for a in arguments]
    done = subprocess.run(
        [sys.executable, EXAMPLES / f"{name}.py", *arguments], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    if name != "material_in_mitsuba":
        assert "nan" not in done.stdout and len(done.stdout) > 100
    if name != "database_to_frame":
        assert list(tmp_path.iterdir())
