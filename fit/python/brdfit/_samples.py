"""Measured reflectance."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _brdfit
from ._arrays import Float32s, floats, last, pairs, vectors
from ._device import DeviceLike, wish
from ._errors import InputError
from ._progress import Progress, reporter

Path = Union[str, "os.PathLike[str]"]


class Samples:
    """Measured reflectance: N samples of C channels. Never changes; its arrays are read-only.

    Parameters
    ----------
    wi, wo : array_like, shape (N, 3)
        Unit vectors to the light and to the viewer (within 1e-3, they are normalised), x along the
        tangent, z along the normal; on the horizon or above it.
    values : array_like, shape (N, C) or (N,)
        The BRDF in 1/sr, without the cosine; finite.
    weights : array_like, shape (N,), optional
        What a sample counts in a fit: the solid angle it stands for, 0 or more. All 1 by default.
    channels : sequence of str, optional
        Names of the channels. R, G and B of three, otherwise channel_1 and so on.
    isotropic : bool, optional
        Whether only the azimuth between wi and wo matters. By default where all wi have azimuth 0.

    Raises
    ------
    InputError
        Naming the argument and the element that is not as described.
    """

    __slots__ = ("_core",)
    _core: _brdfit.SampleSet

    def __init__(
        self,
        wi: npt.ArrayLike,
        wo: npt.ArrayLike,
        values: npt.ArrayLike,
        weights: npt.ArrayLike | None = None,
        channels: Sequence[str] | None = None,
        isotropic: bool | None = None,
    ) -> None:
        lights, viewers, rows = vectors("wi", wi), vectors("wo", wo), floats("values", values)
        for name, array in (("wi", lights), ("wo", viewers)):
            if array.ndim != 2:
                raise InputError(f"{name}: shape {array.shape}; expected (N, 3)")
        if rows.ndim == 1:
            rows = rows[:, np.newaxis]
        if rows.ndim != 2:
            raise InputError(f"values: shape {rows.shape}; expected (N, C)")
        column: npt.NDArray[Any] | None = None
        if weights is not None:
            column = floats("weights", weights)
            if column.ndim != 1:
                raise InputError(f"weights: shape {column.shape}; expected (N,)")
            column = column[:, np.newaxis]
        if isinstance(channels, str):
            raise InputError(f"channels: {channels!r}; expected a sequence of names")
        names = None if channels is None else [str(name) for name in channels]
        self._core = _brdfit.SampleSet.of(lights, viewers, rows, column, names, isotropic)

    @classmethod
    def _of(cls, core: _brdfit.SampleSet) -> Samples:
        samples = cls.__new__(cls)
        samples._core = core
        return samples

    @property
    def wi(self) -> Float32s:
        """Unit vectors to the light, shape (N, 3), float32."""
        wi: Float32s = self._core.wi().T
        return wi

    @property
    def wo(self) -> Float32s:
        """Unit vectors to the viewer, shape (N, 3), float32."""
        wo: Float32s = self._core.wo().T
        return wo

    @property
    def values(self) -> Float32s:
        """The BRDF in 1/sr, shape (N, C), float32; what is not valid has any value."""
        values: Float32s = self._core.values().T
        return values

    @property
    def weights(self) -> Float32s:
        """What each sample counts, shape (N,), float32."""
        weights = self._core.weights()
        return np.ones(len(self), np.float32) if weights is None else weights

    @property
    def valid(self) -> npt.NDArray[np.bool_]:
        """Which samples count, shape (N,)."""
        return self._core.valid().view(np.bool_)

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels."""
        return tuple(self._core.channels)

    @property
    def wavelengths(self) -> npt.NDArray[np.float64] | None:
        """In nm, shape (C,), where every channel is named by one; otherwise None."""
        try:
            return np.array([float(name) for name in self._core.channels])
        except ValueError:
            return None

    @property
    def isotropic(self) -> bool:
        """Whether only the azimuth between wi and wo matters."""
        return self._core.isotropic

    @property
    def source(self) -> str:
        """The file it was read from, or "samples"."""
        return self._core.source

    @property
    def format(self) -> str:
        """The file's format, for people."""
        return self._core.format

    @property
    def sha256(self) -> str:
        """Of the file's bytes; empty where they were no file."""
        return self._core.sha256

    def save(self, path: Path, *, progress: Progress = None) -> None:
        """Writes the valid samples, in the format of the name's ending, as `brdfit convert` does.

        .binary (MERL, of isotropic data of three channels), .csv (scattered), .astm, .npy or .npz.
        The file appears whole or not at all and replaces an older one. Raises InputError for another ending,
        and for data that the format cannot hold.
        """
        with reporter(progress, "writing") as report:
            self._core.save(os.fspath(path), report)

    def eval(
        self, wi: npt.ArrayLike, wo: npt.ArrayLike, *, device: DeviceLike = None, progress: Progress = None
    ) -> Float32s:
        """The BRDF in 1/sr at any directions, without the cosine: wi, wo (..., 3) -> (..., C).

        Files are interpolated as `brdfit eval` does: MERL and UTIA linearly on their grids, RGL by
        its warp, everything else, samples from arrays too, by the mean of the eight nearest samples
        weighted by the inverse square of their distance. 0 below the horizon. wi and wo as
        Material.eval takes them.
        """
        shape, lights, viewers = pairs(wi, wo)
        if len(lights) == 0:
            return np.zeros((*shape, len(self.channels)), np.float32)
        with reporter(progress, "evaluating") as report:
            return last(self._core.eval(lights, viewers, list(shape), wish(device), report), shape)

    def __len__(self) -> int:
        return self._core.count

    def __repr__(self) -> str:
        kind = "isotropic" if self.isotropic else "anisotropic"
        return (
            f"<brdfit.Samples {self.source!r}: {len(self)} samples, {self._core.valid_count} valid, "
            f"{len(self.channels)} channels, {kind}, {self.format}>"
        )


def read(path: Path, *, isotropic: bool | None = None) -> Samples:
    """Reads measured reflectance in any format that brdfit knows, recognised by content.

    Parameters
    ----------
    path
        The file.
    isotropic
        Overrides what scattered data says of itself.

    Raises
    ------
    InputError
        Naming the file, the place in it and what was expected; also where `isotropic` contradicts
        the format.
    """
    return Samples._of(_brdfit.SampleSet.read(os.fspath(path), isotropic))
