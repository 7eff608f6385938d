"""Comparisons of materials and measurements."""

from __future__ import annotations

import json
from typing import Any, Union

from . import _brdfit
from ._arrays import number, whole
from ._device import DeviceLike, wish
from ._errors import InputError
from ._material import Material
from ._progress import Progress, reporter
from ._samples import Samples


def compare(
    a: Union[Material, Samples],
    b: Union[Material, Samples],
    *,
    max_theta: float = 80.0,
    worst: int = 5,
    device: DeviceLike = None,
    progress: Progress = None,
) -> dict[str, Any]:
    """How B differs from A, each a Material or Samples: what `brdfit compare --json` says, but for the names.

    At the samples of A where it is measured, otherwise at B's, otherwise on MERL's grid, in the
    channels that both have; one channel each goes together whatever the names.

    Parameters
    ----------
    a, b
        A is the data that B is compared with.
    max_theta : float
        Degrees, 1 to 90; samples beyond are dropped.
    worst : int
        How many of the samples that differ most are listed, 0 to 1000.

    Returns
    -------
    dict
        `errors` by metric, `bias`, `relative` errors, `bands` of the angles theta_i, theta_h and
        theta_d (degrees), the `worst` samples, and `at`, `channels`, `samples`. None where there is
        no finite number.

    Raises
    ------
    InputError
        Where no channel is common, or no sample is left.
    """
    for name, one in (("a", a), ("b", b)):
        if not isinstance(one, (Material, Samples)):
            raise InputError(f"{name}: {type(one).__name__}; expected a Material or Samples")
    with reporter(progress, "evaluating") as report:
        text = _brdfit.compare(
            a._core, b._core, number("max_theta", max_theta, 1, 90), whole("worst", worst, 0, 1000), wish(device), report
        )
    found: dict[str, Any] = json.loads(text)
    return found
