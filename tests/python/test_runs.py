"""Runs: their results, and their tasks through other schedulers, against the program's run."""

import json
import multiprocessing
import sys
from concurrent.futures import ProcessPoolExecutor

import pytest

import brdfit
from conftest import command, without_times


@pytest.fixture(scope="module")
def run(measured_file, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    command("plan", measured_file, "-m", "lambert,ward,kurt", "-o", folder / "run")
    command("run", folder / "run")
    return folder / "run"


@pytest.fixture(scope="module")
def rows(run):
    """What the program's run found, by the id of the task."""
    lines = [json.loads(line) for log in run.glob("shards/*.jsonl") for line in log.read_text().splitlines()]
    return {row["id"]: row for row in lines}


def test_results_are_those_of_merge(run, tmp_path):
    pandas = pytest.importorskip("pandas")
    command("merge", run, "-o", tmp_path / "r.sqlite", "--csv", tmp_path / "r.csv")
    theirs = pandas.read_csv(tmp_path / "r.csv")
    pandas.testing.assert_frame_equal(brdfit.results(run), theirs, check_exact=True)


def test_tasks_are_those_of_the_plan(run, rows):
    plan = json.loads((run / "plan.json").read_text())
    tasks = brdfit.tasks(run)
    assert [task["tasks"][0]["id"] for task in tasks] == [task["id"] for task in plan["tasks"]]
    assert set(rows) == {task["id"] for task in plan["tasks"]}


def agree(ours, rows):
    assert {row["id"] for row in ours} == set(rows)
    for row in ours:
        theirs = rows[row["id"]]
        assert row["state"] == theirs["state"] == "done"
        assert without_times(row["material"]) == without_times(theirs["material"])


def test_tasks_one_by_one_give_the_rows_of_the_run(run, rows):
    agree([brdfit.fit_task(task) for task in brdfit.tasks(run)], rows)


def test_tasks_in_other_processes_give_the_rows_of_the_run(run, rows):
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        agree(list(pool.map(brdfit.fit_task, brdfit.tasks(run))), rows)


def test_tasks_in_dask_give_the_rows_of_the_run(run, rows):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, processes=False, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            agree(client.gather(client.map(brdfit.fit_task, brdfit.tasks(run))), rows)


def test_a_task_that_fails_says_why(measured_file, tmp_path):
    path = tmp_path / "s.csv"
    path.write_bytes(measured_file.read_bytes())
    command("plan", path, "-m", "ward", "-o", tmp_path / "run")
    task = brdfit.tasks(tmp_path / "run")[0]
    path.write_bytes(b"theta_i,phi_i,theta_o,phi_o,R\n0,0,0,0,1\n")
    row = brdfit.fit_task(task)
    assert row["state"] == "failed" and "has changed since the plan" in row["reason"]


def test_a_changed_task_is_refused(run):
    task = brdfit.tasks(run)[0]
    task["settings"]["max_theta"] = 10
    with pytest.raises(brdfit.InputError, match="plan"):
        brdfit.fit_task(task)


def _in_a_fork(queue):
    try:
        brdfit.Material(0.5).eval([0, 0, 1], [0, 0, 1])
        queue.put("evaluated")
    except brdfit.DeviceError as error:
        queue.put(str(error))


@pytest.mark.skipif(sys.platform != "linux", reason="fork is Linux's")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_forked_process_is_refused_with_a_sentence():
    brdfit.Material(0.5).eval([0, 0, 1], [0, 0, 1])
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    process = context.Process(target=_in_a_fork, args=(queue,))
    process.start()
    message = queue.get(timeout=60)
    process.join()
    assert "forked" in message and "spawn" in message
