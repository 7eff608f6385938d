"""Ctrl-C stops what is under way, in a process of its own, which goes on as if nothing had been."""

import signal
import subprocess
import sys

import pytest

import brdfit
from conftest import command

BEGIN = """
import sys, brdfit
import numpy as np

def told(share, what):
    print("under way", flush=True)

material = brdfit.Material(0.1, [{"model": "ggx", "ks": 0.5, "f0": 0.3, "a": 0.1}])
try:
"""
END = """
    print("ended by itself")
except KeyboardInterrupt:
    print("interrupted")
print(material.eval([0, 0, 1], [0, 0, 1]).shape, brdfit.fit(sys.argv[1], "lambert")[0].model)
"""
# Each of which would take hours.
CALLS = {
    "fit": "brdfit.fit(sys.argv[1], 'ggx', starts=100000, progress=told)",
    "fit_of_another_metric": "brdfit.fit(sys.argv[1], 'ward', metric='log', starts=100000, progress=told)",
    "fit_that_conserves": "brdfit.fit(sys.argv[1], 'ggx', conserve=True, starts=100000, progress=told)",
    "fit_by_an_algorithm": "brdfit.fit(sys.argv[1], 'kurt', 4, algorithm='crs2_lm', max_evaluations=10**6, progress=told)",
    "albedo": "material.albedo(np.full(10**6, 0.5), np.arange(1e6), 5e-6, progress=told)",
    "sample": "[material.sample([0, 0, 1], 10**7, progress=told) for _ in range(10**5)]",
    "eval": "[material.eval(np.full((10**6, 3), (0, 0, 1)), (0, 0, 1), progress=told) for _ in range(10**5)]",
    "generate": "brdfit.generate({'distribution': 'gaussian', 'sigma_x': 0.1, 'sigma_y': 0.2}, points=10**6, progress=told)",
    "table": "brdfit.table('osl', size=2048, tolerance=5e-6, progress=told)",
    "render": "material.render(size=512, samples=2**24, progress=told)",
}


def interrupted(script, *arguments):
    """Runs it, interrupts it once it is under way; what it says from then on, and the errors."""
    process = subprocess.Popen(
        [sys.executable, "-c", script, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        while process.stdout.readline() != "under way\n":
            assert process.poll() is None, process.communicate()
        process.send_signal(signal.SIGINT)
        said, errors = process.communicate(timeout=120)
    finally:
        process.kill()
    assert process.returncode == 0, errors
    return [line for line in said.splitlines() if line != "under way"], errors


@pytest.mark.parametrize("call", CALLS)
def test_what_is_under_way_stops(call, measured_file):
    said, errors = interrupted(f"{BEGIN}    {CALLS[call]}{END}", measured_file)
    assert said == ["interrupted", "(3,) lambert"]
    assert "leak" not in errors


def test_a_task_stops(measured_file, tmp_path):
    command("plan", measured_file, "-m", "ggx", "--starts", 100000, "-o", tmp_path / "run")
    call = "task = brdfit.tasks(sys.argv[2])[0]; told(0, ''); brdfit.fit_task(task)"
    said, _ = interrupted(f"{BEGIN}    {call}{END}", measured_file, tmp_path / "run")
    assert said == ["interrupted", "(3,) lambert"]
    assert brdfit.tasks(tmp_path / "run")
