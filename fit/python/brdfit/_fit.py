"""Fits of models to samples."""

from __future__ import annotations

import json
import math
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Union, overload

from . import _brdfit
from ._arrays import number, whole
from ._device import DeviceLike, wish
from ._errors import InputError
from ._material import Material
from ._progress import Progress, reporter
from ._samples import Samples, read

if TYPE_CHECKING:
    import pandas


class Fit:
    """A model fitted to samples."""

    __slots__ = ("material", "_row", "_report", "_place")
    #: The fitted material; its `fit` says how.
    material: Material
    _row: dict[str, Any]
    _report: _brdfit.Report
    _place: int

    def __init__(self, material: Material, row: dict[str, Any], report: _brdfit.Report, place: int) -> None:
        self.material = material
        self._row = row
        self._report = report
        self._place = place

    @property
    def model(self) -> str:
        """The model's name, that of a mixture with +."""
        return str(self._row["model"])

    @property
    def lobes(self) -> int:
        """How many lobes it has."""
        return int(self._row["lobes"])

    @property
    def metric(self) -> str:
        """What was minimised."""
        return str(self._row["metric"])

    @property
    def errors(self) -> dict[str, float]:
        """The error in each metric, from the residuals themselves."""
        return dict(self._row["error"])

    @property
    def error(self) -> float:
        """The error in the metric that was minimised."""
        return float(self._row["error"][self.metric])

    @property
    def parameters(self) -> dict[str, float]:
        """Every fitted value by its place in the material: "lobes[0].m", "kd[R]"."""
        return {p["name"]: p["value"] for p in self._row["parameters"]}

    @property
    def standard_errors(self) -> dict[str, float]:
        """Of each of the parameters; NaN where it cannot be told: fixed, at a bound, not determined."""
        return {
            p["name"]: math.nan if p["standard_error"] is None else p["standard_error"]
            for p in self._row["parameters"]
        }

    @property
    def at_bound(self) -> list[str]:
        """The parameters that ended at the end of their range."""
        return [p["name"] for p in self._row["parameters"] if p["at_bound"]]

    @property
    def remarks(self) -> list[str]:
        """What makes it doubtful, for people."""
        return list(self._row["remarks"])

    @property
    def evaluations(self) -> int:
        """Of the objective on all samples."""
        return int(self._row["evaluations"])

    @property
    def seconds(self) -> float:
        """How long it took, without building programs."""
        return float(self._row["seconds"])

    @property
    def provenance(self) -> dict[str, Any]:
        """Data, options, device and version, as the material's file has them under "fit"."""
        return self.material.fit or {}

    def __repr__(self) -> str:
        return f"<brdfit.Fit {self.model} {self.lobes}: {self.metric} {self.error:.4g}>"


class Fits(Sequence[Fit]):
    """The fits of one call, in the order they were asked for."""

    def __init__(self, fits: Sequence[Fit], failed: Sequence[tuple[str, int, str]] = ()) -> None:
        self._fits = tuple(fits)
        #: Those that failed: model, number of lobes, reason.
        self.failed = tuple(failed)

    @property
    def best(self) -> Fit:
        """The fit of the least error in the metric that was minimised."""
        return min(self._fits, key=lambda fit: fit.error)

    def to_frame(self) -> pandas.DataFrame:
        """A pandas.DataFrame with a row a fit, and of the columns of `brdfit fit --csv` all but
        those of files and failures. Needs pandas."""
        import pandas

        with tempfile.TemporaryDirectory(prefix="brdfit-") as folder:
            path = os.path.join(folder, "fits.csv")
            self._fits[0]._report.write_csv(path)
            rows = pandas.read_csv(path).drop(columns=["material_file", "failed"])
        return rows.iloc[[fit._place for fit in self._fits]].reset_index(drop=True)

    @overload
    def __getitem__(self, index: int) -> Fit: ...
    @overload
    def __getitem__(self, index: slice) -> Fits: ...
    def __getitem__(self, index: int | slice) -> Fit | Fits:
        return Fits(self._fits[index], self.failed) if isinstance(index, slice) else self._fits[index]

    def __len__(self) -> int:
        return len(self._fits)

    def __iter__(self) -> Iterator[Fit]:
        return iter(self._fits)

    def __repr__(self) -> str:
        return f"<brdfit.Fits of {len(self)}, {len(self.failed)} failed>"


def _names(models: str | Sequence[str]) -> list[str]:
    names = models.split(",") if isinstance(models, str) else list(models)
    if not names or not all(isinstance(name, str) and name for name in names):
        raise InputError(f"models: {models!r}; expected a name, or a sequence of them")
    return names


def _fixed(fix: Mapping[str, float] | None) -> list[str]:
    return [f"{name}={number(f'fix[{name!r}]', value, -math.inf, math.inf)!r}" for name, value in (fix or {}).items()]


def _bounded(bounds: Mapping[str, tuple[float, float]] | None) -> list[str]:
    texts = []
    for name, ends in (bounds or {}).items():
        try:
            low, high = ends
        except (TypeError, ValueError):
            raise InputError(f"bounds[{name!r}]: {ends!r}; expected two numbers, the lower first") from None
        texts.append(
            f"{name}={number(f'bounds[{name!r}]', low, -math.inf, math.inf)!r}:"
            f"{number(f'bounds[{name!r}]', high, -math.inf, math.inf)!r}"
        )
    return texts


def fit(
    samples: Samples | Union[str, "os.PathLike[str]"],
    models: str | Sequence[str] = "all",
    lobes: int | Sequence[int] | None = None,
    *,
    metric: str = "ngan",
    max_theta: float = 80.0,
    diffuse: str | None = None,
    fix: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    start: Material | None = None,
    starts: int = 0,
    seed: int = 1,
    algorithm: str = "slsqp",
    max_evaluations: int = 500,
    conserve: bool = False,
    device: DeviceLike = None,
    progress: Progress = None,
) -> Fits:
    """Fits models to measured samples: the global optimum of each, as `brdfit fit` finds it.

    Parameters
    ----------
    samples
        Samples, or a file that read() takes.
    models : str or sequence of str
        Names of models(), mixtures "a+b", or "all".
    lobes : int or sequence of int, optional
        Numbers of lobes, 1 to 4; 1 by default, or those that a mixture names.
    metric : str
        What is minimised: "ngan", "l2", "log" or "cbrt"; see Material.errors.
    max_theta : float
        Degrees, 1 to 90; samples beyond are dropped.
    diffuse : str, optional
        The diffuse shape; Lambert's, or what a coupled model brings.
    fix : mapping, optional
        Parameters that are known: {"f0": 0.04}, {"2.alpha": 0} of the second lobe.
    bounds : mapping, optional
        Narrower ranges: {"alpha": (0, 1)}.
    start : Material, optional
        Replaces the global search: only a local optimum is promised then.
    starts, seed : int
        Random starts tried besides the global search, and their seed.
    algorithm, max_evaluations
        NLopt's for the polish, and how many evaluations that may take.
    conserve : bool
        Only materials that reflect no more light than they receive.
    device, progress
        See Material.eval; progress: a function of the share done and a text, True, False, or None,
        a bar of tqdm on a terminal and in a notebook.

    Returns
    -------
    Fits
        Materials are those of the command line, to the bit. Ctrl-C gives up what is under way and
        raises KeyboardInterrupt.

    Raises
    ------
    InputError
        For a contradiction among the arguments.

    Where every fit failed, what the first one failed with.
    """
    measured = samples if isinstance(samples, Samples) else read(samples)
    if start is not None and not isinstance(start, Material):
        raise InputError(f"start: {type(start).__name__}; expected a Material")
    wishes = _brdfit.Wishes()
    wishes.models = _names(models)
    counts: Sequence[object] = () if lobes is None else lobes if isinstance(lobes, Sequence) else (lobes,)
    wishes.lobes = [whole("lobes", count, 1, 4) for count in counts]
    wishes.diffuse = diffuse or ""
    wishes.metric = metric
    wishes.max_theta = number("max_theta", max_theta, 1, 90)
    wishes.fixed = _fixed(fix)
    wishes.bounds = _bounded(bounds)
    wishes.starts = whole("starts", starts, 0, 100000)
    wishes.seed = whole("seed", seed, 0, 2**64 - 1)
    wishes.algorithm = algorithm
    wishes.max_evaluations = whole("max_evaluations", max_evaluations, 1, 1000000)
    wishes.conserve = bool(conserve)
    with reporter(progress, "fitting") as report:
        found = _brdfit.fit(measured._core, wishes, None if start is None else start._core, wish(device), report)
    fits = [
        Fit(Material._of(core), json.loads(row), found, place)
        for place, (core, row) in enumerate(zip(found.materials(), found.json()))
    ]
    return Fits(fits, found.failed())
