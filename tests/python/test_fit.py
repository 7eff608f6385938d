"""Fits: the program's, to the bit; what stops, tells and reports them."""

import json
import math
import threading
import time

import numpy as np
import pytest

import brdfit
from conftest import columns, command, random_pairs, without_times


@pytest.mark.parametrize(
    "models, lobes, options, arguments",
    [
        ("ward", None, ["-m", "ward"], {}),
        (["kurt", "ggx"], None, ["-m", "kurt,ggx"], {}),
        ("lambert", None, ["-m", "lambert"], {}),
        ("ward", 2, ["-m", "ward", "--lobes", "2"], {}),
        ("ward", [1, 2], ["-m", "ward", "--lobes", "1,2"], {}),
        ("kurt+ward", None, ["-m", "kurt+ward"], {}),
        ("kurt-coupled", None, ["-m", "kurt-coupled"], {}),
        ("ward", None, ["-m", "ward", "--metric", "log"], {"metric": "log"}),
        ("ward", None, ["-m", "ward", "--metric", "l2"], {"metric": "l2"}),
        ("kurt", None, ["-m", "kurt", "--fix", "f0=0.05"], {"fix": {"f0": 0.05}}),
        ("kurt", None, ["-m", "kurt", "--bound", "alpha=0:0.05"], {"bounds": {"alpha": (0, 0.05)}}),
        ("ward", None, ["-m", "ward", "--max-theta", "60"], {"max_theta": 60}),
        ("ward", None, ["-m", "ward", "--algorithm", "bobyqa"], {"algorithm": "bobyqa"}),
        ("ward", None, ["-m", "ward", "--starts", "3", "--seed", "4"], {"starts": 3, "seed": 4}),
        ("ashikhmin-shirley", None, ["-m", "ashikhmin-shirley", "--diffuse", "ashikhmin-shirley"],
         {"diffuse": "ashikhmin-shirley"}),
        ("ward", None, ["-m", "ward", "--conserve"], {"conserve": True}),
    ],
)  # fmt: skip
def test_fits_are_the_programs_to_the_bit(models, lobes, options, arguments, measured, measured_file, tmp_path):
    command("fit", measured_file, *options, "-o", tmp_path, "--json")
    theirs = {path.name: json.loads(path.read_text()) for path in tmp_path.iterdir()}
    fits = brdfit.fit(measured, models, lobes, **arguments)
    assert len(fits) == len(theirs) and not fits.failed
    for fit in fits:
        expected = without_times(theirs[f"plastic.{fit.model}.{fit.lobes}.json"])
        assert without_times(fit.material.to_dict()) == expected


def test_a_path_will_do(measured_file):
    assert brdfit.fit(measured_file, "ward")[0].provenance["source"] == str(measured_file)


def test_arrays_fit_as_a_file_of_them(plastic):
    wi, wo = random_pairs(5000, seed=8)
    samples = brdfit.Samples(wi, wo, plastic.eval(wi, wo), isotropic=True)
    best = brdfit.fit(samples, "kurt").best
    assert best.error < 1e-4
    assert best.parameters["lobes[0].m"] == pytest.approx(0.15, rel=1e-3)


def test_a_start_is_taken(measured, measured_file, tmp_path):
    start = brdfit.Material(0.1, [{"model": "ward", "ks": 0.5, "m": 0.3}])
    start.save(tmp_path / "start.json")
    command("fit", measured_file, "-m", "ward", "--start", tmp_path / "start.json", "-o", tmp_path / "out", "--json")
    theirs = json.loads((tmp_path / "out" / "plastic.ward.1.json").read_text())
    ours = brdfit.fit(measured, "ward", start=start)[0].material.to_dict()
    assert without_times(ours) == without_times(theirs)


@pytest.fixture(scope="module")
def fits(measured):
    return brdfit.fit(measured, ["lambert", "ward", "kurt"])


def test_fits_are_a_sequence(fits):
    assert [fit.model for fit in fits] == ["lambert", "ward", "kurt"] and len(fits) == 3
    assert fits[-1].model == "kurt" and [fit.model for fit in fits[:2]] == ["lambert", "ward"]
    assert fits.best is min(fits, key=lambda fit: fit.errors["ngan"])
    assert fits.best.model == "kurt"


def test_a_fit_tells_all(fits):
    fit = fits.best
    assert fit.error == fit.errors["ngan"] == fit.provenance["error"]["ngan"]
    assert set(fit.parameters) == set(fit.standard_errors) >= {"lobes[0].m", "kd[R]", "lobes[0].ks[B]"}
    assert 0 < fit.standard_errors["lobes[0].m"] < 0.01 or math.isnan(fit.standard_errors["lobes[0].m"])
    assert fit.evaluations > 0 and fit.seconds > 0 and fit.at_bound == fit.provenance["at_bound"]
    assert fit.material.lobes[0]["m"] == fit.parameters["lobes[0].m"]


def test_a_frame_has_the_columns_of_the_csv(fits, measured_file, tmp_path):
    pandas = pytest.importorskip("pandas")
    command("fit", measured_file, "-m", "lambert,ward,kurt", "-o", tmp_path, "--csv", tmp_path / "s.csv", "--json")
    theirs = pandas.read_csv(tmp_path / "s.csv")
    theirs = theirs.drop(columns=["material_file", "failed"]).sort_values("model", ignore_index=True)
    ours = fits.to_frame().sort_values("model", ignore_index=True)
    assert list(ours.columns) == list(theirs.columns)
    times = ["seconds", "build_seconds"]
    pandas.testing.assert_frame_equal(ours.drop(columns=times), theirs.drop(columns=times), check_exact=True)
    assert list(fits[1:].to_frame()["model"]) == ["ward", "kurt"]


def test_progress_is_told(measured):
    told = []
    brdfit.fit(measured, ["ward", "kurt", "ggx"], progress=lambda share, what: told.append((share, what)))
    assert told and all(0 <= share <= 1 for share, _ in told)
    assert [share for share, _ in told] == sorted(share for share, _ in told)
    assert any(what.split()[0] in ("ward", "kurt", "ggx") for _, what in told if what)


def test_an_exception_of_progress_comes_out(measured):
    def fail(share, what):
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        brdfit.fit(measured, ["ward", "kurt", "ggx"], progress=fail)


def test_other_threads_run_meanwhile(measured):
    counted = 0

    def count():
        nonlocal counted
        while not over:
            counted += 1
            time.sleep(0.001)

    over = False
    thread = threading.Thread(target=count)
    thread.start()
    brdfit.fit(measured, ["kurt", "ggx", "ward"])
    over = True
    thread.join()
    assert counted > 10


def test_random_starts_are_reported(measured):
    fit = brdfit.fit(measured, "ward", starts=2)[0]
    assert fit.provenance["starts"] == 2 and "random_starts_better" in fit.provenance


def test_a_fit_of_what_is_synthesised_finds_it(plastic, measured_file, tmp_path):
    _ = columns(measured_file)
    best = brdfit.fit(measured_file, ["ward", "kurt", "kurt-coupled"]).best
    assert best.model in ("kurt", "kurt-coupled") and best.material.lobes[0]["m"] == pytest.approx(0.15, rel=0.02)
    assert np.allclose(best.material.diffuse["kd"], plastic.diffuse["kd"], rtol=0.1)
