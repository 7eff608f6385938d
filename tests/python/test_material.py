"""Materials: what they evaluate, sample and integrate to, against the program on the same input."""

import copy
import json
import pickle

import numpy as np
import pytest

import brdfit
from conftest import columns, command, material_of, model_names, random_pairs, typical

FORMS = [pytest.param(True, id="isotropic"), pytest.param(False, id="anisotropic")]


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """Saves a material; returns the path."""
    folder = tmp_path_factory.mktemp("materials")

    def save(material):
        path = folder / f"{len(list(folder.iterdir()))}.json"
        material.save(path)
        return path

    return save


@pytest.mark.parametrize("isotropic", FORMS)
@pytest.mark.parametrize("name", model_names())
def test_eval_is_the_programs_to_the_bit(name, isotropic, pairs, pairs_file, saved, tmp_path):
    material = material_of(name, isotropic)
    command("eval", saved(material), pairs_file, "-o", tmp_path / "f.npy")
    theirs = columns(tmp_path / "f.npy")[:, 6:-1]
    ours = material.eval(*pairs)
    assert ours.dtype == np.float32 and ours.shape == theirs.shape
    np.testing.assert_array_equal(ours, theirs)
    assert (ours > 0).any() and (ours == 0).any()


@pytest.mark.parametrize("name", model_names())
def test_pdf_is_the_programs_to_the_bit(name, pairs, pairs_file, saved, tmp_path):
    material = material_of(name, False)
    command("pdf", saved(material), pairs_file, "-o", tmp_path / "pdf.npy")
    np.testing.assert_array_equal(material.pdf(*pairs), columns(tmp_path / "pdf.npy")[:, 0])


@pytest.mark.parametrize("name", model_names())
def test_sample_is_the_programs_to_the_bit(name, saved, tmp_path):
    material = material_of(name, False)
    viewers = random_pairs(3, seed=5)[0]
    np.save(tmp_path / "wo.npy", viewers)
    command("sample", saved(material), "--wo", tmp_path / "wo.npy", "-n", 500, "--seed", 9, "-o", tmp_path / "s.npy")
    theirs = columns(tmp_path / "s.npy")
    wi, pdf, weight = material.sample(viewers, 500, seed=9)
    assert wi.shape == (3, 500, 3) and pdf.shape == (3, 500) and weight.shape == (3, 500, 3)
    np.testing.assert_array_equal(wi.reshape(-1, 3), theirs[:, :3])
    np.testing.assert_array_equal(pdf.ravel(), theirs[:, 6])
    np.testing.assert_array_equal(weight.reshape(-1, 3), theirs[:, 7:])


@pytest.mark.parametrize("name", model_names())
def test_weights_are_f_times_cosine_over_pdf(name):
    material = material_of(name, True)
    wo = np.array([0.6, 0.0, 0.8])
    wi, pdf, weight = material.sample(wo, 4000, seed=2, sequence="philox")
    kept = pdf > 0
    assert kept.mean() > 0.5
    f = material.eval(wi[kept], wo)
    np.testing.assert_allclose(weight[kept], f * wi[kept][:, 2:] / pdf[kept][:, None], rtol=2e-3, atol=1e-6)
    np.testing.assert_allclose(pdf[kept], material.pdf(wi[kept], wo), rtol=2e-3)


@pytest.mark.parametrize("name", ["lambert", "kurt", "ggx", "ward-duer", "ashikhmin-shirley"])
def test_albedo_is_the_programs_to_the_bit(name, saved, tmp_path):
    material = material_of(name, True)
    command("albedo", saved(material), "--theta", 10, "--tolerance", 1e-3, "-o", tmp_path / "albedo.csv")
    names, theirs = columns(tmp_path / "albedo.csv")
    assert names == ["theta", "phi", "R", "G", "B", "R_error", "G_error", "B_error"]
    theta = np.pi / 2 * np.arange(10) / 9
    np.testing.assert_allclose(theirs[:, 0], theta, rtol=1e-7)
    values, errors = material.albedo(theta, tolerance=1e-3)
    assert values.shape == errors.shape == (10, 3)
    np.testing.assert_array_equal(values.astype(np.float32), theirs[:, 2:5].astype(np.float32))
    np.testing.assert_array_equal(errors.astype(np.float32), theirs[:, 5:8].astype(np.float32))


def test_albedo_is_the_mean_weight():
    material = material_of("ggx", True)
    theta = 0.7
    wo = np.array([np.sin(theta), 0, np.cos(theta)])
    _, _, weight = material.sample(wo, 1 << 16)
    values, errors = material.albedo(theta)
    assert values.shape == (3,) and (errors < 2e-4).all()
    np.testing.assert_allclose(weight.mean(axis=0), values, atol=5e-4)


def test_albedo_of_lambert_is_its_kd():
    values, _ = brdfit.Material(diffuse=[0.1, 0.5, 0.9]).albedo(np.linspace(0, np.pi / 2, 5))
    np.testing.assert_allclose(values, np.tile([0.1, 0.5, 0.9], (5, 1)), rtol=1e-5)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_any_strides_give_the_same(dtype, plastic):
    wi, wo = random_pairs(500, dtype=dtype)
    expected = plastic.eval(wi, wo)
    for change in (
        np.asfortranarray,
        lambda a: np.repeat(a, 2, axis=0)[::2],
        lambda a: a[::-1].copy()[::-1],
        lambda a: np.concatenate([a, a], axis=1)[:, :3],
        lambda a: a.astype(a.dtype.newbyteorder()),
        lambda a: np.array([(r, 7) for r in a], dtype=[("v", dtype, 3), ("n", "i1")])["v"],
    ):
        np.testing.assert_array_equal(plastic.eval(change(wi), change(wo)), expected)


def test_float32_is_float64_of_the_same_numbers(plastic):
    wi, wo = random_pairs(500, dtype=np.float32)
    np.testing.assert_array_equal(plastic.eval(wi, wo), plastic.eval(wi.astype(np.float64), wo.astype(np.float64)))


def test_read_only_arrays_lists_and_integers(plastic):
    wi, wo = random_pairs(20)
    expected = plastic.eval(wi, wo)
    wi.flags.writeable = False
    np.testing.assert_array_equal(plastic.eval(wi, wo.tolist()), expected)
    assert plastic.eval([0, 0, 1], (0, 0, 1)).shape == (3,)


class Exporter:
    """An array of another library: DLPack alone."""

    def __init__(self, array):
        self.array = array

    def __dlpack__(self, **options):
        return self.array.__dlpack__(**options)

    def __dlpack_device__(self):
        return self.array.__dlpack_device__()


def test_dlpack(plastic):
    wi, wo = random_pairs(20)
    np.testing.assert_array_equal(plastic.eval(Exporter(wi), Exporter(wo)), plastic.eval(wi, wo))


@pytest.mark.parametrize(
    "lights, viewers, expected",
    [
        ((3,), (3,), ()),
        ((5, 3), (3,), (5,)),
        ((3,), (5, 3), (5,)),
        ((4, 1, 3), (1, 5, 3), (4, 5)),
        ((2, 4, 5, 3), (5, 3), (2, 4, 5)),
        ((0, 3), (3,), (0,)),
        ((0, 3), (4, 1, 3), (4, 0)),
    ],
)
def test_shapes_broadcast(lights, viewers, expected, plastic):
    rng = np.random.default_rng(4)

    def unit(shape):
        v = np.abs(rng.normal(size=shape)) + 0.01
        return v / np.linalg.norm(v, axis=-1, keepdims=True)

    wi, wo = unit(lights), unit(viewers)
    f, pdf = plastic.eval(wi, wo), plastic.pdf(wi, wo)
    assert f.shape == (*expected, 3) and pdf.shape == expected
    wide, tall = np.broadcast_arrays(wi, wo)
    for index in np.ndindex(*expected):
        np.testing.assert_array_equal(f[index], plastic.eval(wide[index], tall[index]))
        break


@pytest.mark.parametrize("shape", [(), (4,), (2, 3), (0,)])
def test_sample_takes_any_shape_of_viewers(shape, plastic):
    wo = np.broadcast_to([0.6, 0, 0.8], (*shape, 3))
    wi, pdf, weight = plastic.sample(wo, 7)
    assert wi.shape == (*shape, 7, 3) and pdf.shape == (*shape, 7) and weight.shape == (*shape, 7, 3)


def test_seeds_and_sequences_differ(plastic):
    draws = [plastic.sample([0, 0, 1], 50, seed=s, sequence=q)[0] for s in (1, 2) for q in ("sobol", "philox")]
    for i, a in enumerate(draws):
        for b in draws[:i]:
            assert not np.array_equal(a, b)
    np.testing.assert_array_equal(plastic.sample([0, 0, 1], 50, seed=1)[0], draws[0])


@pytest.mark.parametrize("channels", [1, 2, 3, 7])
def test_any_number_of_channels(channels):
    material = brdfit.Material(diffuse=np.full(channels, 0.5))
    assert len(material.channels) == channels
    f = material.eval([0, 0, 1], [0, 0, 1])
    np.testing.assert_allclose(f, np.full(channels, 0.5 / np.pi), rtol=1e-6)


@pytest.mark.parametrize("isotropic", FORMS)
@pytest.mark.parametrize("name", model_names())
def test_dicts_files_and_pickles_keep_all(name, isotropic, tmp_path):
    material = material_of(name, isotropic)
    material.save(tmp_path / "m.json")
    for other in (
        brdfit.Material.from_dict(material.to_dict()),
        brdfit.Material.load(tmp_path / "m.json"),
        pickle.loads(pickle.dumps(material)),
        copy.deepcopy(material),
    ):
        assert other == material and hash(other) == hash(material)
    assert json.loads((tmp_path / "m.json").read_text()) == material.to_dict()
    assert material.isotropic or not isotropic


def test_what_it_returns_is_a_copy(plastic):
    data = plastic.to_dict()
    data["diffuse"]["kd"][0] = 9
    plastic.lobes[0]["m"] = 9
    assert plastic.diffuse["kd"][0] == 0.3 and plastic.lobes[0]["m"] == 0.15
    with pytest.raises(AttributeError):
        plastic.lobes = []
    with pytest.raises(AttributeError):
        plastic.colour = "red"


def test_unlike_materials_are_unlike(plastic):
    assert plastic != brdfit.Material(diffuse=0.5)
    assert plastic != "plastic"


def test_kd_and_ks_may_be_one_number():
    one = brdfit.Material(0.25, [{"model": "ward", "ks": 0.5, "m": 0.2}])
    assert one.diffuse["kd"] == [0.25] * 3 and one.lobes[0]["ks"] == [0.5] * 3
    assert one.channels == ("R", "G", "B")
    named = brdfit.Material(0.25, channels=["450", "550"])
    assert named.diffuse["kd"] == [0.25] * 2


def test_errors_are_those_of_a_fit(measured):
    fit = brdfit.fit(measured, "ward")[0]
    errors = fit.material.errors(measured)
    assert set(errors) == {"ngan", "l2", "log", "cbrt"}
    for metric, error in errors.items():
        assert error == pytest.approx(fit.errors[metric], rel=1e-5)


def test_errors_are_the_programs(measured, measured_file, saved):
    material = material_of("ggx", True)
    theirs = json.loads(command("compare", measured_file, saved(material), "--max-theta", 70, "--json"))
    assert material.errors(measured, max_theta=70) == theirs["errors"]


def test_a_notebook_sees_a_table_and_a_picture(plastic):
    text = plastic._repr_html_()
    assert "kurt" in text and "<svg" in text and text.count("<polyline") == 3
    assert "nan" not in text
    assert "kurt" in repr(plastic)


def test_export_is_what_convert_writes(plastic, saved, tmp_path):
    path = saved(plastic)
    plastic.export(tmp_path / path.with_suffix(".bsdf").name)
    command("convert", path, tmp_path / "theirs.bsdf")
    ours = (tmp_path / path.with_suffix(".bsdf").name).read_bytes()
    theirs = (tmp_path / "theirs.bsdf").read_bytes()
    # but for the name of the source in the description
    assert abs(len(ours) - len(theirs)) < 64 and ours[-100000:] == theirs[-100000:]
    matrix = path.with_suffix(".xml").name  # which has the material's name in it
    plastic.export(tmp_path / matrix)
    (tmp_path / "theirs").mkdir()
    command("convert", path, tmp_path / "theirs" / matrix)
    assert (tmp_path / matrix).read_bytes() == (tmp_path / "theirs" / matrix).read_bytes()
    plastic.export(tmp_path / "m.json")
    assert brdfit.Material.load(tmp_path / "m.json") == plastic


def test_two_threads_at_once(plastic):
    from concurrent.futures import ThreadPoolExecutor

    wi, wo = random_pairs(20000)
    expected = plastic.eval(wi, wo)
    viewers = wo[:4]
    drawn = plastic.sample(viewers, 1000)
    with ThreadPoolExecutor(4) as pool:
        evals = [pool.submit(plastic.eval, wi, wo) for _ in range(8)]
        draws = [pool.submit(plastic.sample, viewers, 1000) for _ in range(8)]
        for future in evals:
            np.testing.assert_array_equal(future.result(), expected)
        for future in draws:
            np.testing.assert_array_equal(future.result()[0], drawn[0])


def test_typical_materials_are_of_all_models():
    assert len(model_names()) >= 15
    assert all(typical(model, False) for model in brdfit.models() if not model.table)
