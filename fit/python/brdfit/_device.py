"""Devices, and how calls name one."""

from __future__ import annotations

from typing import Union

from . import _brdfit
from ._brdfit import Device
from ._errors import InputError

#: By its place in devices(), by a part of its name, platform or vendor, or None: the default.
DeviceLike = Union[Device, int, str, None]


def devices() -> list[Device]:
    """Every OpenCL device of this machine; an empty list where there is none.

    Raises DeviceError where why there is none is known.
    """
    return _brdfit.devices()


def wish(device: DeviceLike) -> str:
    """The device as the library takes it."""
    if device is None:
        return ""
    if isinstance(device, Device):
        return str(device.index)
    if isinstance(device, str):
        return device
    if isinstance(device, bool) or not hasattr(device, "__index__"):
        raise InputError(f"device: {device!r}; expected a Device, its index or a part of its name")
    return str(int(device))
