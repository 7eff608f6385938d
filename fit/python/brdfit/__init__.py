"""Evaluates models of reflectance (BRDFs) and fits them to measurements, on any OpenCL device.

>>> import brdfit
>>> samples = brdfit.read("nickel.binary")
>>> fits = brdfit.fit(samples, ["ggx", "ward"])
>>> fits.best.material.eval(wi, wo)        # 1/sr, without the cosine

Directions are unit vectors in the frame of the surface, x along the tangent, z along the normal; wi
to the light, wo to the viewer. Angles are radians, but for max_theta, as on the command line
degrees.
"""

from . import _brdfit
from ._brdfit import Device, Model, Parameter
from ._compare import compare
from ._device import devices
from ._errors import DeviceError, InputError
from ._fit import Fit, Fits, fit
from ._material import Material
from ._runs import fit_task, report, results, tasks
from ._samples import Samples, read
from ._tables import Axis, Distribution, Table, generate, presets, table

_brdfit.use_errors(InputError, DeviceError)

__version__: str = _brdfit.version


def models() -> list[Model]:
    """The models of the catalogue, as `brdfit models` lists them."""
    return _brdfit.models()


__all__ = [
    "Axis",
    "Device",
    "DeviceError",
    "Distribution",
    "Fit",
    "Fits",
    "InputError",
    "Material",
    "Model",
    "Parameter",
    "Samples",
    "Table",
    "compare",
    "devices",
    "fit",
    "fit_task",
    "generate",
    "models",
    "presets",
    "read",
    "report",
    "results",
    "table",
    "tasks",
]
