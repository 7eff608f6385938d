"""Large runs: their results, and their tasks one by one for other schedulers."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from . import _brdfit
from ._device import DeviceLike, wish
from ._errors import InputError
from ._progress import Progress, reporter
from ._samples import Path

if TYPE_CHECKING:
    import pandas


def results(run: Path, *, progress: Progress = None) -> pandas.DataFrame:
    """What a run has finished, a row a fit, with the columns of `brdfit merge --csv`.

    `run` is the folder of `brdfit plan`; it may be going on. Needs pandas.
    """
    import pandas

    with tempfile.TemporaryDirectory(prefix="brdfit-") as folder, reporter(progress, "reading") as report:
        path = os.path.join(folder, "results.csv")
        _brdfit.merge_to_csv(os.fspath(run), path, report)
        return pandas.read_csv(path)


def tasks(run: Path) -> list[dict[str, Any]]:
    """The tasks of a plan, each a dict for fit_task that stands for itself: it can be pickled and
    sent to any process that sees the files."""
    with tempfile.TemporaryDirectory(prefix="brdfit-") as folder:
        plans = []
        for alone in _brdfit.write_tasks(os.fspath(run), folder):
            with open(os.path.join(alone, "plan.json"), encoding="utf-8") as file:
                plans.append(json.load(file))
        return plans


def fit_task(task: Mapping[str, Any], *, device: DeviceLike = None) -> dict[str, Any]:
    """Does one of tasks(run); returns its row as the run's log has it.

    Keys: `id`, `state` ("done", or "failed" with the `reason`), `file`, `material` (as
    Material.from_dict takes it) and times. The result depends on the task alone, so that tasks may
    be given to concurrent.futures (by spawn) or Dask in any order.
    """
    if not isinstance(task, Mapping):
        raise InputError(f"task: {type(task).__name__}; expected one of tasks(run)")
    with tempfile.TemporaryDirectory(prefix="brdfit-") as folder:
        with open(os.path.join(folder, "plan.json"), "w", encoding="utf-8") as file:
            json.dump(task, file)
        row: dict[str, Any] = json.loads(_brdfit.run_only_task(folder, wish(device), None))
        return row
