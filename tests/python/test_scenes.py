"""The scene with global illumination, where Mitsuba 3 is installed to render it."""

import csv
import subprocess
import sys

import pytest

import brdfit
from conftest import PROGRAM, ROOT, command

mi = pytest.importorskip("mitsuba")


def table(*arguments):
    script = ROOT / "host/render/scenes/table.py"
    return subprocess.run([sys.executable, script, "--brdfit", PROGRAM, *map(str, arguments)], capture_output=True,
                          text=True)  # fmt: skip


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scene")
    lobe = {"model": "kurt", "ks": [0.9, 0.8, 0.6], "f0": 0.8, "m": 0.15, "alpha": 0.1}
    brdfit.Material(diffuse=[0.05, 0.05, 0.05], lobes=[lobe]).save(folder / "metal.json")
    command("synth", folder / "metal.json", folder / "metal.binary")
    return folder / "metal.binary"


def test_the_model_that_the_data_is_of_looks_like_it(measured, tmp_path):
    options = (measured, "-o", tmp_path / "out", "-m", "kurt,lambert", "--lobes", 1, "--size", "48x30", "--samples", 64)
    done = table(*options)
    assert done.returncode == 0, done.stderr
    assert "4 of 4: lambert, 100 %" in done.stderr or "4 of 4: kurt, 100 %" in done.stderr
    with open(tmp_path / "out/psnr.csv") as file:
        psnr = {row["model"]: float(row["psnr"]) for row in csv.DictReader(file)}
    assert psnr.keys() == {"measured again", "kurt", "lambert"}
    assert psnr["measured again"] > 25
    assert abs(psnr["kurt"] - psnr["measured again"]) < 1
    assert psnr["lambert"] < psnr["kurt"] - 3
    mi.set_variant("scalar_rgb")
    picture = mi.Bitmap(str(tmp_path / "out/kurt.exr"))
    assert tuple(picture.size()) == (48, 30)
    assert tuple(mi.Bitmap(str(tmp_path / "out/strip.jpg")).size()) == (3 * 48 + 2 * 4, 30)

    again = table(*options)
    assert again.returncode == 2
    assert "not empty; --force" in again.stderr


def test_refuses_what_it_cannot_render(measured, tmp_path):
    missing = table(tmp_path / "no.binary", "-o", tmp_path / "a")
    assert missing.returncode == 1
    assert "no.binary" in missing.stderr
    assert table(measured, "-o", tmp_path / "b", "-m", "phong").returncode == 2
    for wrong in (("--size", "48"), ("--samples", "0"), ("--bounces", "-1")):
        done = table(measured, "-o", tmp_path / "c", *wrong)
        assert done.returncode == 2
        assert "expected" in done.stderr
    assert not (tmp_path / "c").exists()
