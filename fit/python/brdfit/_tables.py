"""Tables for renderers, and tables of distributions of normals."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any, NamedTuple, Union

import numpy as np

from . import _brdfit
from ._arrays import Float32s, Float64s, number, whole
from ._device import DeviceLike, wish
from ._errors import InputError
from ._material import _plain
from ._progress import Progress, reporter
from ._samples import Path


class Axis(NamedTuple):
    """An axis of a table."""

    name: str
    """cos_theta, roughness, f0, ior or parameter:NAME."""
    values: Float64s
    """Its nodes."""
    mapping: str
    """How they come from their numbers, for people."""


class Table:
    """A table of albedos over roughness and the like, as renderers read it."""

    __slots__ = ("_core",)
    _core: _brdfit.RenderTable

    def __init__(self, core: _brdfit.RenderTable) -> None:
        self._core = core

    @property
    def values(self) -> Float64s:
        """Indexed by the axes in their order, and last by `channels`."""
        planes = self._core.values()
        return np.transpose(planes, tuple(range(planes.ndim - 1, -1, -1)))

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Fastest first in the files."""
        return tuple(Axis(*row) for row in self._core.axes())

    @property
    def channels(self) -> tuple[str, ...]:
        """What each entry holds: the albedo, or two terms of it."""
        return tuple(self._core.channels)

    @property
    def error(self) -> float:
        """The largest error of an entry, estimated."""
        return self._core.error

    @property
    def provenance(self) -> dict[str, str]:
        """What the table is: quantity, axes, order, encoding, model, tolerance, error, software."""
        return dict(self._core.provenance())

    def save(self, path: Path, *, clamp: bool = False) -> None:
        """Writes .exr, .h, .hpp, .inc (C source), .npy or .csv, as `brdfit table` does.

        Replaces an older file. `clamp`: values that the encoding unorm16 cannot hold are cut off,
        where they would raise InputError.
        """
        self._core.save(os.fspath(path), clamp)

    def __repr__(self) -> str:
        sizes = " x ".join(f"{axis.name} {len(axis.values)}" for axis in self.axes)
        return f"<brdfit.Table {', '.join(self.channels)} over {sizes}>"


def presets() -> dict[str, str]:
    """The tables that renderers read, by name, and whose they are."""
    return dict(_brdfit.presets())


def table(
    preset_or_spec: str | Mapping[str, Any] | "os.PathLike[str]",
    *,
    model: str | None = None,
    tolerance: float | None = None,
    size: int | None = None,
    encoding: str | None = None,
    parameters: Mapping[str, float] | None = None,
    device: DeviceLike = None,
    progress: Progress = None,
    **axes: Union[int, Mapping[str, Any]],
) -> Table:
    """Tabulates albedos for a renderer.

    Parameters
    ----------
    preset_or_spec
        A name of presets(); a specification, as a mapping or the path of a .json; or with `axes` a
        quantity: "albedo", "complement", "scale-bias" or "multiple-scattering".
    model, tolerance, size, encoding
        In place of the preset's: another model than "ggx", the absolute error of the albedos, nodes
        of the axes cos_theta and roughness, "float", "half" or "unorm16" in files.
    parameters : mapping, optional
        Of the model, those that no axis sets: {"alpha": 0.2}.
    **axes
        Axes of one's own, fastest first: cos_theta=64, roughness={"size": 64, "power": 2}, f0=16,
        ior=..., or a parameter of the model: alpha=3. A size, or the keys of a specification.

    Raises
    ------
    InputError
        Naming the key and what was expected there, also where an entry is infinite or does not
        reach the tolerance.
    """
    changes = _brdfit.Changes()
    changes.model = model or ""
    changes.encoding = encoding or ""
    changes.tolerance = 0.0 if tolerance is None else number("tolerance", tolerance, 5e-6, 1)
    changes.size = 0 if size is None else whole("size", size, 2, 4096)
    changes.parameters = {name: number(f"parameters[{name!r}]", x, -1e30, 1e30) for name, x in (parameters or {}).items()}
    what, source, preset = preset_or_spec, "specification", False
    if axes:
        if not isinstance(what, str):
            raise InputError("preset_or_spec: expected the name of a quantity beside axes")
        what = {"quantity": what, "model": model or "ggx", "axes": [_axis(name, axis) for name, axis in axes.items()]}
    elif isinstance(what, str) and not what.endswith(".json"):
        preset = True
    elif not isinstance(what, Mapping):
        source = os.fspath(what)
        what = _read(source)
    text = what if isinstance(what, str) else json.dumps(what, default=_plain)
    with reporter(progress, "tabulating") as report:
        return Table(_brdfit.table(str(text), preset, source, changes, wish(device), report))


def _read(path: str) -> str:
    try:
        with open(path, encoding="utf-8") as file:
            return file.read()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: {error}") from error


def _axis(name: str, axis: int | Mapping[str, Any]) -> dict[str, Any]:
    known = ("cos_theta", "roughness", "f0", "ior")
    kind = name if name in known or name.startswith("parameter:") else f"parameter:{name}"
    return {"axis": kind, **(axis if isinstance(axis, Mapping) else {"size": whole(name, axis, 2, 4096)})}


class Distribution:
    """A generated microfacet BRDF: the tables that lobes of the model "microfacet" read.

    Arrays are indexed by elevation and azimuth, float32.
    """

    __slots__ = ("_core",)
    _core: _brdfit.GeneratedTable

    def __init__(self, core: _brdfit.GeneratedTable) -> None:
        self._core = core

    @property
    def name(self) -> str:
        """What the distribution is, for people."""
        return self._core.name

    @property
    def isotropic(self) -> bool:
        """Whether there is one azimuth only."""
        return self._core.isotropic

    @property
    def mean(self) -> Float64s:
        """The integral of h p(h) over the sphere, shape (3,)."""
        return np.array(self._core.mean)

    @property
    def mean_height(self) -> float:
        """<h.n>."""
        return self._core.mean_height

    @property
    def elevations(self) -> Float64s:
        """Of the rows, above the horizon, radians."""
        return self._core.elevations()

    @property
    def azimuths(self) -> Float64s:
        """Of the columns, radians."""
        return self._core.azimuths()

    @property
    def g(self) -> Float32s:
        """The area of facets that a direction sees (Eq. 18 of the paper)."""
        return self._core.g()

    def reflectance(self, f0: int, *, correlated: bool = False) -> Float32s:
        """The albedo R at f0 = 0 or 1 (Eq. 29), with independent or with correlated shadowing."""
        return self._core.reflectance(whole("f0", f0, 0, 1), correlated)

    def save(self, path: Path) -> None:
        """Writes the .exr that a lobe names as its `table`; replaces an older one."""
        name = os.fspath(path)
        if not name.endswith(".exr"):
            raise InputError(f"{name}: unknown ending; expected .exr")
        self._core.save(name)

    def __repr__(self) -> str:
        return f"<brdfit.Distribution {self.name}: {len(self.elevations)} elevations, {len(self.azimuths)} azimuths>"


def generate(
    spec: Mapping[str, Any] | Path,
    *,
    points: int = 200,
    lambertian: bool = False,
    device: DeviceLike = None,
    progress: Progress = None,
) -> Distribution:
    """Generates a microfacet BRDF from a distribution of normals, as `brdfit generate` does.

    Parameters
    ----------
    spec
        A specification, {"distribution": "gaussian", "sigma_x": 0.1, "sigma_y": 0.2}, or the path
        of one (.json).
    points : int
        Of the grid, about; 16 to 1000000.
    lambertian : bool
        Also tabulate Lambertian facets; isotropic distributions only.
    """
    if isinstance(spec, Mapping):
        text, source = json.dumps(spec, default=_plain), "distribution"
    else:
        source = os.fspath(spec)
        text = _read(source)
    with reporter(progress, "generating") as report:
        return Distribution(
            _brdfit.generate(text, source, whole("points", points, 16, 1000000), bool(lambertian), wish(device), report)
        )
