"""Samples: read as the program reads them, made from arrays, written, evaluated anywhere."""

import numpy as np
import pytest

import brdfit
from conftest import columns, command, random_pairs


def test_read_tells_what_info_does(measured, measured_file):
    import json

    theirs = json.loads(command("info", measured_file, "--json"))
    theirs = theirs[0] if isinstance(theirs, list) else theirs
    assert len(measured) == theirs["samples"] == 4000
    assert int(measured.valid.sum()) == theirs["valid"]
    assert measured.isotropic == theirs["isotropic"]
    assert measured.format == theirs["format"] and measured.sha256 == theirs["sha256"]
    assert measured.source == str(measured_file)


def test_arrays_are_read_only_views(measured):
    for array in (measured.wi, measured.wo, measured.values, measured.valid):
        assert not array.flags.writeable and not array.flags.owndata
    assert measured.wi.shape == measured.wo.shape == (4000, 3) and measured.values.shape == (4000, 3)
    assert measured.weights.shape == (4000,)
    values = measured.values
    del measured
    assert np.isfinite(values).all()


def test_what_arrays_hold_outlives_the_samples(measured_file):
    samples = brdfit.read(measured_file)
    wi, kept = samples.wi, samples.wi.copy()
    del samples
    np.testing.assert_array_equal(wi, kept)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("channels", [1, 3, 5])
@pytest.mark.parametrize("weighted", [False, True])
def test_arrays_are_the_same_as_a_file_of_them(dtype, channels, weighted, tmp_path):
    wi, wo = random_pairs(300, dtype=dtype)
    rng = np.random.default_rng(1)
    values = rng.random((300, channels)).astype(dtype)
    weights = rng.random(300).astype(dtype) if weighted else np.ones(300, dtype)
    np.save(tmp_path / "s.npy", np.concatenate([wi, wo, values, weights[:, None]], axis=1))
    theirs = brdfit.read(tmp_path / "s.npy")
    ours = brdfit.Samples(wi, wo, values, weights if weighted else None)
    for name in ("wi", "wo", "values", "weights", "valid", "channels", "isotropic"):
        np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name))


@pytest.mark.parametrize("ending", [".csv", ".npy"])
def test_saved_and_read_again(ending, measured, measured_file, tmp_path):
    measured.save(tmp_path / f"ours{ending}")
    again = brdfit.read(tmp_path / f"ours{ending}")
    np.testing.assert_array_equal(again.values, measured.values)
    np.testing.assert_allclose(again.wi, measured.wi, atol=1e-6)
    command("convert", measured_file, tmp_path / f"theirs{ending}")
    ours, theirs = columns(tmp_path / f"ours{ending}"), columns(tmp_path / f"theirs{ending}")
    if ending == ".csv":
        assert ours[0] == theirs[0]
        ours, theirs = ours[1], theirs[1]
    np.testing.assert_array_equal(ours, theirs)


def test_eval_of_a_file_is_the_programs_to_the_bit(measured, measured_file, pairs, pairs_file, tmp_path):
    command("eval", measured_file, pairs_file, "-o", tmp_path / "f.npy")
    np.testing.assert_array_equal(measured.eval(*pairs), columns(tmp_path / "f.npy")[:, 6:-1])


def test_eval_of_arrays_is_that_of_a_file_of_them(measured, pairs):
    ours = brdfit.Samples(measured.wi, measured.wo, measured.values, isotropic=measured.isotropic)
    ours.eval(*pairs)
    found = ours.eval(measured.wi[:50], measured.wo[:50])
    np.testing.assert_allclose(found, measured.values[:50], rtol=1e-3, atol=1e-5)


def test_eval_of_merl_is_the_programs(plastic, pairs, pairs_file, tmp_path):
    plastic.save(tmp_path / "m.json")
    command("synth", tmp_path / "m.json", tmp_path / "m.binary")
    samples = brdfit.read(tmp_path / "m.binary")
    assert len(samples) == 90 * 90 * 180 and samples.channels == ("R", "G", "B") and samples.isotropic
    command("eval", tmp_path / "m.binary", pairs_file, "-o", tmp_path / "f.npy")
    np.testing.assert_array_equal(samples.eval(*pairs), columns(tmp_path / "f.npy")[:, 6:-1])
    (tmp_path / "m.binary").write_bytes(b"other")
    assert samples.eval(*pairs).shape == (3000, 3)  # what was evaluated once is there


def test_what_the_library_warns_of_is_a_warning(tmp_path):
    theta = np.linspace(0.1, 1, 40)
    wi = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=1)
    samples = brdfit.Samples(wi, wi, -np.ones((40, 3)), isotropic=True)
    with pytest.warns(UserWarning, match="negative values became 0"):
        samples.save(tmp_path / "s.binary")


def test_a_file_that_changed_is_not_evaluated(measured_file, tmp_path):
    path = tmp_path / "s.csv"
    path.write_bytes(measured_file.read_bytes())
    samples = brdfit.read(path)
    path.write_bytes(b"\n".join(measured_file.read_bytes().splitlines()[:-3]) + b"\n")
    with pytest.raises(brdfit.InputError, match="has changed since"):
        samples.eval([0, 0, 1], [0, 0, 1])


def test_wavelengths(tmp_path):
    wi, wo = random_pairs(10)
    spectral = brdfit.Samples(wi, wo, np.ones((10, 3)), channels=["450", "550.5", "650"])
    np.testing.assert_array_equal(spectral.wavelengths, [450, 550.5, 650])
    assert brdfit.Samples(wi, wo, np.ones((10, 3))).wavelengths is None


def test_isotropic_where_all_lights_have_azimuth_0():
    wi, wo = random_pairs(10)
    flat = np.stack([np.hypot(wi[:, 0], wi[:, 1]), np.zeros(10), wi[:, 2]], axis=1)
    assert brdfit.Samples(flat, wo, np.ones(10)).isotropic
    assert not brdfit.Samples(wi, wo, np.ones(10)).isotropic
    assert brdfit.Samples(wi, wo, np.ones(10), isotropic=True).isotropic


def test_isotropic_overrides_a_file(measured_file):
    assert not brdfit.read(measured_file, isotropic=False).isotropic
