"""Pictures: the program's, to the bit."""

import math

import numpy as np
import pytest

import brdfit
from conftest import command

SHINY = {"model": "ggx", "ks": [0.5, 0.4, 0.3], "f0": 0.3, "ax": 0.1, "ay": 0.3}


@pytest.fixture(scope="module")
def material():
    return brdfit.Material(diffuse=[0.3, 0.2, 0.1], lobes=[SHINY])


def pixels(path):
    """The .exr that the program wrote, red, green and blue."""
    mi = pytest.importorskip("mitsuba")
    mi.set_variant("scalar_rgb")
    return np.array(mi.Bitmap(str(path)))[..., :3]


@pytest.mark.parametrize(
    "shape, options, arguments",
    [
        ("sphere", [], {}),
        ("sphere", ["--size", "24x16"], {"size": (24, 16)}),
        ("row:2", ["--environment", "sky", "--turn", "30", "--bounces", "2"],
         {"environment": "sky", "turn": math.radians(30), "bounces": 2}),
        ("ground", ["--ground", "0.1,0.2,0.3", "--view", "60", "--around", "20", "--angle", "40"],
         {"ground": (0.1, 0.2, 0.3), "view": math.radians(60), "around": math.radians(20), "angle": math.radians(40)}),
        ("cylinder", ["--brushed", "along", "--light", "point:3,-4,5,60", "--backdrop", "0.5"],
         {"brushed": "along", "lights": ["point:3,-4,5,60"], "backdrop": 0.5}),
        ("plane", ["--sampling", "material", "--seed", "7"], {"sampling": "material", "seed": 7}),
        ("sphere", ["--tolerance", "0.2"], {"tolerance": 0.2}),
    ],
)  # fmt: skip
def test_pictures_are_the_programs_to_the_bit(shape, options, arguments, material, tmp_path):
    material.save(tmp_path / "m.json")
    size = [] if "--size" in options else ["--size", 16]
    samples = [] if "--tolerance" in options else ["--samples", 8]
    command("render", tmp_path / "m.json", "-o", tmp_path / "p.exr", "--pixel", "float", "--shape", shape, *size, *samples, *options)
    given = {**({} if size == [] else {"size": 16}), **({} if samples == [] else {"samples": 8}), **arguments}
    ours = material.render(shape, **given)
    assert ours.dtype == np.float32 and ours.ndim == 3
    np.testing.assert_array_equal(ours, pixels(tmp_path / "p.exr"))


def test_in_a_white_furnace_it_shows_its_albedo():
    picture = brdfit.Material(diffuse=[0.2, 0.5, 0.8]).render(size=(9, 5), samples=64, environment="white")
    assert picture.shape == (5, 9, 3)
    np.testing.assert_allclose(picture[2, 4], [0.2, 0.5, 0.8], rtol=0.02)


def test_a_tolerance_that_is_not_reached_is_a_warning(material):
    with pytest.warns(UserWarning, match="tolerance 1e-06 is not reached with 4 samples"):
        material.render(size=8, samples=4, tolerance=1e-6)


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"shape": "cube"}, "shape cube: expected sphere"),
        ({"size": 0}, "size: 0"),
        ({"size": 9000}, "size: 9000"),
        ({"size": (8192, 8192)}, "size: 8192 x 8192 pixels; expected at most"),
        ({"size": (1, 2, 3)}, r"size: \(1, 2, 3\)"),
        ({"size": "big"}, "size: 'big'"),
        ({"samples": 0}, "samples: 0"),
        ({"samples": 2**40}, "samples: "),
        ({"environment": "night"}, "environment night: expected softbox"),
        ({"environment": "missing.exr"}, "missing.exr"),
        ({"environment": "none"}, "without light"),
        ({"lights": "point:1,2,3,4"}, "lights: expected a sequence"),
        ({"lights": ["lamp:1"]}, "light lamp:1"),
        ({"lights": ["point:1,2,3,nan"]}, "light point"),
        ({"turn": math.nan}, "turn: nan"),
        ({"turn": 1, "environment": "none", "lights": ["point:3,-4,5,60"]}, "turn: changes nothing"),
        ({"ground": 0.1}, "ground: changes nothing"),
        ({"shape": "ground", "ground": 2}, "ground: 2"),
        ({"shape": "ground", "ground": (1, 0)}, r"ground: shape \(2,\)"),
        ({"backdrop": -1}, "backdrop: -1"),
        ({"bounces": 1}, "bounces: changes nothing"),
        ({"shape": "row:2", "bounces": 65}, "bounces: 65"),
        ({"brushed": "up"}, "brushed: 'up'"),
        ({"shape": "plane", "view": 1.6}, "view: a plane is seen from above"),
        ({"view": 4}, "view: 4"),
        ({"angle": 0}, "angle: 0"),
        ({"tolerance": 0}, "tolerance: 0"),
        ({"sampling": "often"}, "sampling: 'often'"),
        ({"seed": -1}, "seed: -1"),
    ],
)
def test_bad_input(arguments, message, material):
    with pytest.raises(brdfit.InputError, match=message):
        material.render(**{"size": 8, "samples": 1, **arguments})


def test_channels_that_are_no_colours():
    with pytest.raises(brdfit.InputError, match="material"):
        brdfit.Material(diffuse=[0.1, 0.2]).render(size=8, samples=1)
