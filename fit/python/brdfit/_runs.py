"""Large runs: their results, a report of them, and their tasks one by one for other schedulers."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from . import _brdfit
from ._arrays import whole
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


def report(
    folder: Path,
    path: Path,
    *,
    materials: Sequence[str] = (),
    models: Sequence[str] = (),
    metric: str | None = None,
    model: str | None = None,
    size: int = 192,
    samples: int = 32,
    device: DeviceLike = None,
    progress: Progress = None,
) -> None:
    """Writes one page (.html) of the fits in a folder, that of a run or of `brdfit fit`, with pictures.

    Replaces an older page, where `brdfit report` asks for --force.

    Parameters
    ----------
    materials, models : sequence of str
        Those to show: names of materials, with * and ?, and of models; all by default.
    metric : str, optional
        Shows the fits that minimise it; the first of the run by default.
    model : str, optional
        MODEL or MODEL:LOBES to set beside each material's best fit; by default the one of the
        fewest lobes with the least mean error.
    size, samples : int
        Of the pictures, pixels (0: no pictures) and samples a pixel.
    """
    name = os.fspath(path)
    if not name.endswith((".html", ".htm")):
        raise InputError(f"{name}: unknown ending; expected .html")
    for argument, names in (("materials", materials), ("models", models)):
        if isinstance(names, str):
            raise InputError(f"{argument}: {names!r}; expected a sequence of names")
    sides, count = whole("size", size, 0, 1024), whole("samples", samples, 1, 65536)
    with reporter(progress, "reading the fits") as told:
        _brdfit.report(
            os.fspath(folder), name, list(materials), list(models), metric or "", model or "", sides, count, wish(device), told
        )


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
