"""Materials: what a fit ends in, and what evaluates, samples and integrates."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _brdfit, _mitsuba, _notebook
from ._arrays import Float32s, Float64s, floats, last, number, pairs, rows, vectors, whole
from ._device import DeviceLike, wish
from ._errors import InputError
from ._progress import Progress, reporter
from ._render import Colour, wishes
from ._samples import Path, Samples

#: kd, a number or one a channel, or the object "diffuse" of a material file.
Diffuse = Union[float, Sequence[float], Mapping[str, Any]]


def _strengths(name: str, value: object, channels: int) -> list[float]:
    array = floats(name, value)
    if array.ndim == 0:
        array = np.full(channels, array)
    if array.shape != (channels,):
        raise InputError(f"{name}: shape {array.shape}; expected one number, or {channels}, one a channel")
    return [float(x) for x in array]


def _channel_count(*strengths: object) -> int:
    """How many channels the first kd or ks that is no single number has; 3 of none."""
    for strength in strengths:
        if strength is not None and np.ndim(strength) == 1:  # type: ignore[arg-type]
            return len(strength)  # type: ignore[arg-type]
    return 3


class Material:
    """A BRDF: f(wi, wo) = kd diffuse(wi, wo) + sum over lobes of ks g(wi, wo), a channel.

    Never changes; use to_dict and from_dict to make another one. Equal materials compare equal.

    Parameters
    ----------
    diffuse
        kd, one number or one a channel (Lambert's model, 1/pi of it), or a mapping with `model` and
        `kd`: "lambert", "kurt-coupled", "ashikhmin-shirley", ...
    lobes : sequence of mappings, up to 4
        Each with `model`, `ks` (one number or one a channel) and the model's parameters, as
        models() lists them: one roughness of an isotropic lobe, two of an anisotropic one.
    channels : sequence of str, optional
        Their names. As many as kd and ks say, R, G and B of three.

    Raises
    ------
    InputError
        Naming the key and what was expected there.

    Examples
    --------
    >>> brdfit.Material(diffuse=0.2, lobes=[{"model": "ggx", "ks": 0.8, "f0": 0.04, "a": 0.1}])
    """

    __slots__ = ("_core", "_folder")
    _core: _brdfit.SharedMaterial
    _folder: str

    def __init__(
        self,
        diffuse: Diffuse = 0.0,
        lobes: Sequence[Mapping[str, Any]] = (),
        *,
        channels: Sequence[str] | None = None,
    ) -> None:
        base: dict[str, Any] = dict(diffuse) if isinstance(diffuse, Mapping) else {"model": "lambert", "kd": diffuse}
        if isinstance(lobes, (str, Mapping)) or not all(isinstance(lobe, Mapping) for lobe in lobes):
            raise InputError("lobes: expected a sequence of mappings, one a lobe")
        parts: list[dict[str, Any]] = [dict(lobe) for lobe in lobes]
        if channels is not None:
            names = [str(name) for name in channels]
        else:
            count = _channel_count(base.get("kd"), *(lobe.get("ks") for lobe in parts))
            names = ["R", "G", "B"] if count == 3 else [f"channel_{c + 1}" for c in range(count)]
        if "kd" in base:
            base["kd"] = _strengths("kd", base["kd"], len(names))
        for i, lobe in enumerate(parts):
            if "ks" in lobe:
                lobe["ks"] = _strengths(f"lobes[{i}].ks", lobe["ks"], len(names))
        self._set({"brdfit": 1, "channels": names, "diffuse": base, "lobes": parts}, "")

    def _set(self, data: Mapping[str, Any], folder: str) -> None:
        self._folder = folder
        try:
            text = json.dumps(data, default=_plain)
        except (TypeError, ValueError) as error:
            raise InputError(f"material: {error}; expected what JSON can hold") from error
        self._core = _brdfit.SharedMaterial.parse(text, os.path.join(folder, "material"))

    @classmethod
    def _of(cls, core: _brdfit.SharedMaterial, folder: str = "") -> Material:
        material = cls.__new__(cls)
        material._core = core
        material._folder = folder
        return material

    @classmethod
    def load(cls, path: Path) -> Material:
        """Reads a material file. Raises InputError naming the file, the key and what was expected."""
        name = os.fspath(path)
        return cls._of(_brdfit.SharedMaterial.read(name), os.path.dirname(os.path.abspath(name)))

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], *, folder: Path = "") -> Material:
        """The material that a dict of to_dict, or a material file as JSON, describes.

        `folder` is where tables that it names are looked for.
        """
        if not isinstance(data, Mapping):
            raise InputError(f"data: {type(data).__name__}; expected a mapping, as to_dict returns it")
        material = cls.__new__(cls)
        material._set(data, os.fspath(folder))
        return material

    def to_dict(self) -> dict[str, Any]:
        """The material as its file has it, a new dict each time."""
        data: dict[str, Any] = json.loads(self._core.json())
        return data

    def save(self, path: Path) -> None:
        """Writes a material file, whole or not at all; replaces an older one."""
        self._core.save(os.fspath(path))

    def export(self, path: Path, *, device: DeviceLike = None, progress: Progress = None) -> None:
        """Writes the material for other programs, in the format of the name's ending.

        .bsdf is the RGL database's format, which Mitsuba reads ("measured"), and .xml a Klems matrix
        (Radiance, WINDOW), both tabulated as `brdfit convert` does; .json is a material file.
        """
        name = os.fspath(path)
        if name.endswith(".json"):
            self.save(name)
            return
        if not name.endswith((".bsdf", ".xml")):
            raise InputError(f"{name}: unknown ending; expected .bsdf, .xml or .json")
        write = self._core.write_rgl if name.endswith(".bsdf") else self._core.write_klems
        with reporter(progress, "tabulating") as report:
            write(name, os.path.basename(name), wish(device), report)

    def to_mitsuba(self, path: Path | None = None, *, device: DeviceLike = None) -> dict[str, Any]:
        """A dict for mitsuba.load_dict: its plugin "measured" with a file of export().

        The file is `path` (.bsdf), or a temporary one that goes when Python ends.
        """
        name = _mitsuba.temporary_file() if path is None else os.fspath(path)
        self.export(name, device=device)
        return {"type": "measured", "filename": name}

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels."""
        return tuple(self._core.channels)

    @property
    def diffuse(self) -> dict[str, Any]:
        """The diffuse part, `model` and `kd`; a copy."""
        part: dict[str, Any] = self.to_dict()["diffuse"]
        return part

    @property
    def lobes(self) -> list[dict[str, Any]]:
        """The lobes, `model`, `ks` and parameters; a copy."""
        parts: list[dict[str, Any]] = self.to_dict()["lobes"]
        return parts

    @property
    def fit(self) -> dict[str, Any] | None:
        """How it was fitted; None where it was not."""
        return self.to_dict().get("fit")

    @property
    def isotropic(self) -> bool:
        """Whether turning wi and wo together about the normal changes nothing."""
        return self._core.isotropic

    def eval(
        self, wi: npt.ArrayLike, wo: npt.ArrayLike, *, device: DeviceLike = None, progress: Progress = None
    ) -> Float32s:
        """The BRDF in 1/sr, without the cosine: wi (..., 3), wo (..., 3) -> (..., C), float32.

        Parameters
        ----------
        wi, wo : array_like, float32 or float64
            Unit vectors to the light and to the viewer (within 1e-3, they are normalised), x along
            the tangent, z along the normal. Shapes broadcast as NumPy's do. Any strides; DLPack's
            arrays of the host too.
        device
            A Device, its index or a part of its name; the default one otherwise.

        Returns
        -------
        numpy.ndarray
            0 where either direction is below the horizon, finite everywhere. Channels are stored
            one after the other: numpy.ascontiguousarray makes rows of them.

        Raises
        ------
        InputError
            Naming the argument and the element that is no unit vector.
        DeviceError
            Where there is no OpenCL device, or it fails.
        """
        shape, lights, viewers = pairs(wi, wo)
        if len(lights) == 0:
            return np.zeros((*shape, len(self.channels)), np.float32)
        with reporter(progress, "evaluating") as report:
            return last(self._core.eval(lights, viewers, list(shape), wish(device), report), shape)

    def pdf(
        self, wi: npt.ArrayLike, wo: npt.ArrayLike, *, device: DeviceLike = None, progress: Progress = None
    ) -> Float32s:
        """The density, by solid angle (1/sr), with which sample draws wi for wo: (..., 3), (..., 3) -> (...).

        Arguments as eval's; 0 below the horizon.
        """
        shape, lights, viewers = pairs(wi, wo)
        if len(lights) == 0:
            return np.zeros(shape, np.float32)
        with reporter(progress, "evaluating") as report:
            return self._core.pdf(lights, viewers, list(shape), wish(device), report).reshape(shape)

    def sample(
        self,
        wo: npt.ArrayLike,
        n: int,
        *,
        seed: int = 0,
        sequence: str = "sobol",
        device: DeviceLike = None,
        progress: Progress = None,
    ) -> tuple[Float32s, Float32s, Float32s]:
        """Draws n light directions for each viewer: wo (..., 3) -> wi (..., n, 3), pdf (..., n), weight (..., n, C).

        Parameters
        ----------
        wo : array_like
            Unit vectors above the horizon.
        n : int
            How many of each; at most 1e8 in all.
        seed : int
            Another seed, other samples. Sample i of all depends on its wo, seed and i alone.
        sequence : str
            "sobol", evenly spread, or "philox", independent.

        Returns
        -------
        wi, pdf, weight
            Unit vectors; their density by solid angle, 1/sr; f wi_z / pdf, the mean of which is the
            albedo of wo. Rejected samples, below the horizon, have pdf and weight 0.
        """
        viewers = vectors("wo", wo)
        shape = viewers.shape[:-1]
        if sequence not in ("sobol", "philox"):
            raise InputError(f"sequence: {sequence!r}; expected 'sobol' or 'philox'")
        count = whole("n", n, 1, 2**63 - 1)
        key = whole("seed", seed, 0, 2**64 - 1)
        drawn = (*shape, count)
        if viewers.size == 0:
            empty = np.zeros((*drawn, max(3, len(self.channels))), np.float32)
            return empty[..., :3], empty[..., 0], empty[..., : len(self.channels)]
        with reporter(progress, "drawing") as report:
            planes = self._core.sample(
                rows(viewers), list(shape), count, key, sequence == "sobol", wish(device), report
            )
        return last(planes[:3], drawn), planes[3].reshape(drawn), last(planes[4:], drawn)

    def albedo(
        self,
        theta: npt.ArrayLike,
        phi: npt.ArrayLike = 0.0,
        tolerance: float = 1e-4,
        *,
        device: DeviceLike = None,
        progress: Progress = None,
    ) -> tuple[Float64s, Float64s]:
        """The directional albedo R = integral of f wi_z over wi: theta, phi (...) -> R, error (..., C).

        Parameters
        ----------
        theta, phi : array_like
            The viewer's angle from the normal, 0 to pi/2 (there, the limit), and azimuth, radians.
            They broadcast.
        tolerance : float
            Absolute error to refine to, from 5e-6 to below 1.

        Returns
        -------
        R, error
            float64; infinite where the integral diverges. The error is estimated and absolute, and
            above the tolerance where that costs too much.
        """
        try:
            thetas, phis = np.broadcast_arrays(floats("theta", theta), floats("phi", phi))
        except ValueError as error:
            raise error if isinstance(error, InputError) else InputError(f"theta and phi: {error}") from None
        if not bool(np.all((thetas >= 0) & (thetas <= np.pi / 2 + 1e-6))):  # as float32 rounds it
            raise InputError("theta: expected angles from 0 to pi/2, radians")
        if not bool(np.all(np.isfinite(phis))):
            raise InputError("phi: expected finite angles, radians")
        shape = thetas.shape
        if thetas.size == 0:
            return np.zeros((*shape, len(self.channels))), np.zeros((*shape, len(self.channels)))
        with reporter(progress, "integrating") as report:
            values, errors = self._core.albedo(
                np.minimum(thetas, np.pi / 2).ravel().tolist(),
                phis.ravel().tolist(),
                number("tolerance", tolerance, 0, 1),
                wish(device),
                report,
            )
        return last(values, shape), last(errors, shape)

    def render(
        self,
        shape: str = "sphere",
        *,
        size: int | tuple[int, int] = 512,
        samples: int | None = None,
        environment: str | None = None,
        lights: Sequence[str] = (),
        turn: float = 0.0,
        ground: Colour | None = None,
        backdrop: Colour | None = None,
        brushed: str = "around",
        view: float | None = None,
        around: float = -math.pi / 2,
        angle: float = math.radians(25),
        bounces: int = 0,
        tolerance: float | None = None,
        sampling: str = "both",
        seed: int = 0,
        device: DeviceLike = None,
        progress: Progress = None,
    ) -> Float32s:
        """A picture of it on a simple shape, linear red, green and blue in W/(m2 sr) -> (H, W, 3), float32.

        The values of `brdfit render -o picture.exr --pixel float`; row 0 is the top one.

        Parameters
        ----------
        shape : str
            "sphere", "row:N" or "grid:COLUMNSxROWS" of spheres, "cylinder", "plane", or "ground", a
            sphere on a plane.
        size : int or (int, int)
            Pixels, or width and height; 1 to 8192, 2**24 in all.
        samples : int, optional
            A pixel; 64 by default, with a `tolerance` at most 65536.
        environment : str, optional
            "softbox" (the default without lights), "sky", "white", "none", or a latitude-longitude
            .exr.
        lights : sequence of str
            "point:X,Y,Z,INTENSITY", "directional:THETA,PHI,IRRADIANCE" (degrees) or
            "rectangle:X,Y,Z,WIDTH,HEIGHT,RADIANCE".
        turn : float
            Of the environment about the vertical, radians.
        ground, backdrop
            Albedo of the plane under the sphere of "ground", 0.5 by default; radiance behind the
            shapes in place of the environment. One number, or red, green and blue.
        brushed : str
            Which way the tangent runs: "around" the shape's axis, or "along" it.
        view, around, angle : float
            The camera's angle from straight above (pi/2, above planes 70 degrees, by default), its
            azimuth, and the picture's smaller angle of view; radians.
        bounces : int
            Of light between the shapes, 0 to 64.
        tolerance : float, optional
            Ends where the noise is at most this share of the mean radiance; warns where it is not
            reached.
        sampling : str
            How directions are drawn: "both" (lights and material), "lights", "material" or
            "uniform". All tend to the same picture.
        seed : int
            Another seed, other noise.

        Raises
        ------
        InputError
            Naming the argument; also for a material whose channels are not one, three or
            wavelengths.
        """
        wished = wishes(
            shape=shape, size=size, samples=samples, environment=environment, lights=lights, turn=turn, ground=ground,
            backdrop=backdrop, brushed=brushed, view=view, around=around, angle=angle, bounces=bounces,
            tolerance=tolerance, sampling=sampling, seed=seed,
        )  # fmt: skip
        with reporter(progress, "rendering") as report:
            return np.moveaxis(_brdfit.render(self._core, wished, wish(device), report), 0, -1)

    def errors(
        self,
        samples: Samples,
        *,
        max_theta: float = 80.0,
        device: DeviceLike = None,
        progress: Progress = None,
    ) -> dict[str, float]:
        """How far it is from measured samples: the errors "ngan", "l2", "log" and "cbrt".

        The roots of weighted mean squares over valid samples with both directions within max_theta
        degrees of the normal, of wi_z (f - y) ("ngan"; "l2" unweighted), of the difference of
        ln(1 + wi_z f) ("log") and of the cube root of wi_z f ("cbrt").
        """
        if not isinstance(samples, Samples):
            raise InputError(f"samples: {type(samples).__name__}; expected Samples, as read() returns them")
        with reporter(progress, "evaluating") as report:
            return self._core.errors(samples._core, number("max_theta", max_theta, 1, 90), wish(device), report)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Material):
            return NotImplemented
        return self.to_dict() == other.to_dict()

    def __hash__(self) -> int:
        return hash(self._core.json())

    def __reduce__(self) -> tuple[Any, ...]:
        return _from_text, (self._core.json(), self._folder)

    def __repr__(self) -> str:
        return f"<brdfit.Material {_notebook.summary(self.to_dict())}>"

    def _repr_html_(self) -> str:
        return _notebook.material_html(self)


def _plain(value: object) -> object:
    """NumPy's numbers and arrays as JSON has them."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{type(value).__name__} {value!r}")


def _from_text(text: str, folder: str) -> Material:
    return Material.from_dict(json.loads(text), folder=folder)
