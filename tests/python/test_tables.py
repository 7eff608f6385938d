"""Tables for renderers and generated distributions, against the program's files."""

import json

import numpy as np
import pytest

import brdfit
from conftest import command


@pytest.mark.parametrize("preset", ["cycles-average", "openpbr-average"])
def test_a_preset_is_the_programs(preset, tmp_path):
    command("table", preset, "-o", tmp_path / "theirs.npy", "--tolerance", 1e-3)
    table = brdfit.table(preset, tolerance=1e-3)
    table.save(tmp_path / "ours.npy")
    assert (tmp_path / "ours.npy").read_bytes() == (tmp_path / "theirs.npy").read_bytes()
    assert json.loads((tmp_path / "ours.npy.json").read_text()) == json.loads((tmp_path / "theirs.npy.json").read_text())
    assert table.values.shape == (*(len(axis.values) for axis in table.axes), len(table.channels))
    assert table.error <= 1e-3 and table.provenance["model"]


def test_values_are_indexed_by_the_axes(tmp_path):
    table = brdfit.table("albedo", model="kurt", tolerance=1e-3, cos_theta=4, roughness=3, parameters={"alpha": 0})
    assert [axis.name for axis in table.axes] == ["cos_theta", "roughness"]
    assert table.values.shape == (4, 3, 1)
    table.save(tmp_path / "t.csv")
    rows = [line.split(",") for line in (tmp_path / "t.csv").read_text().splitlines() if line[0] != "#"]
    assert rows[0] == ["cos_theta", "roughness", "E"]
    for row in rows[1:]:
        i = np.argmin(abs(table.axes[0].values - float(row[0])))
        j = np.argmin(abs(table.axes[1].values - float(row[1])))
        assert table.values[i, j, 0] == pytest.approx(float(row[2]), rel=1e-6)


def test_a_spec_may_be_a_dict_or_a_file(tmp_path):
    spec = {"quantity": "albedo", "model": "ggx", "tolerance": 1e-3,
            "axes": [{"axis": "cos_theta", "size": 3}, {"axis": "roughness", "size": 2}, {"axis": "f0", "size": 2}]}  # fmt: skip
    (tmp_path / "spec.json").write_text(json.dumps(spec))
    of_dict, of_file = brdfit.table(spec), brdfit.table(tmp_path / "spec.json")
    np.testing.assert_array_equal(of_dict.values, of_file.values)
    np.testing.assert_array_equal(of_dict.values, brdfit.table(str(tmp_path / "spec.json")).values)
    assert of_dict.values.shape == (3, 2, 2, 1)


def test_size_model_and_parameters_replace_a_presets(tmp_path):
    command("table", "osl", "-m", "kurt", "--fix", "alpha=0", "--size", 4, "--tolerance", 1e-3, "-o", tmp_path / "t.npy")
    table = brdfit.table("osl", model="kurt", parameters={"alpha": 0}, size=4, tolerance=1e-3)
    table.save(tmp_path / "ours.npy")
    assert (tmp_path / "ours.npy").read_bytes() == (tmp_path / "t.npy").read_bytes()


def test_presets_are_listed():
    assert {"cycles", "filament", "osl"} <= set(brdfit.presets())


SPEC = {"distribution": "gaussian", "sigma_x": 0.3, "sigma_y": 0.4}


def test_a_distribution_is_the_programs(tmp_path):
    (tmp_path / "spec.json").write_text(json.dumps(SPEC))
    theirs = json.loads(command("generate", tmp_path / "spec.json", "-o", tmp_path / "theirs.exr", "--points", 16, "--json"))
    made = brdfit.generate(SPEC, points=16)
    made.save(tmp_path / "ours.exr")
    assert (tmp_path / "ours.exr").read_bytes() == (tmp_path / "theirs.exr").read_bytes()
    assert made.name == theirs["distribution"] and made.mean_height == theirs["mean_height"]
    assert made.g.shape == (theirs["rows"], theirs["columns"]) == (len(made.elevations), len(made.azimuths))
    assert made.reflectance(1).shape == made.g.shape and not made.isotropic
    assert made.reflectance(0, correlated=True).max() <= made.reflectance(1, correlated=True).max()
    np.testing.assert_allclose(made.mean[:2], 0, atol=1e-6)


def test_a_material_reads_a_generated_table(pairs, tmp_path):
    brdfit.generate(SPEC, points=16).save(tmp_path / "gauss.exr")
    data = {"brdfit": 1, "channels": ["R"], "diffuse": {"model": "lambert", "kd": [0]},
            "lobes": [{"model": "microfacet", "ks": [1], "f0": 0.5, "table": "gauss.exr"}]}  # fmt: skip
    material = brdfit.Material.from_dict(data, folder=tmp_path)
    material.save(tmp_path / "m.json")
    assert brdfit.Material.load(tmp_path / "m.json") == material
    import pickle

    again = pickle.loads(pickle.dumps(material))
    np.testing.assert_array_equal(again.eval(*pairs), material.eval(*pairs))
    np.save(tmp_path / "p.npy", np.concatenate(list(pairs), axis=1))
    command("eval", tmp_path / "m.json", tmp_path / "p.npy", "-o", tmp_path / "f.npy")
    np.testing.assert_array_equal(material.eval(*pairs), np.load(tmp_path / "f.npy")[:, 6:-1])
