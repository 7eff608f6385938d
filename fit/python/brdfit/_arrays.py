"""What arrays callers may pass: anything NumPy takes, and DLPack's of the host."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import InputError

Floats = npt.NDArray[np.floating[Any]]
Float32s = npt.NDArray[np.float32]
Float64s = npt.NDArray[np.float64]


def floats(name: str, values: object) -> Floats:
    """An array of float32 or float64, in this machine's byte order; no copy where it is one."""
    array: Any
    try:
        if not isinstance(values, np.ndarray) and hasattr(values, "__dlpack__"):
            array = np.from_dlpack(values)
        else:
            array = np.asarray(values)
    except (TypeError, ValueError, BufferError, RuntimeError) as error:
        raise InputError(f"{name}: no array on the host: {error}") from error
    if array.dtype.kind not in "fiub" or array.dtype.itemsize > 8:
        raise InputError(f"{name}: {array.dtype}; expected numbers, float32 or float64")
    if array.dtype not in (np.float32, np.float64):
        array = array.astype(np.float32 if array.dtype == np.float16 else np.float64)
    if not array.dtype.isnative or any(stride % array.itemsize for stride in array.strides):
        array = np.ascontiguousarray(array, array.dtype.newbyteorder("="))
    found: Floats = array
    return found


def vectors(name: str, values: object) -> Floats:
    """An array of shape (..., 3)."""
    array = floats(name, values)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise InputError(f"{name}: shape {array.shape}; expected (..., 3)")
    return array


def pairs(wi: object, wo: object) -> tuple[tuple[int, ...], Floats, Floats]:
    """The shape that wi and wo have together, without its 3, and each as (N, 3)."""
    lights, viewers = vectors("wi", wi), vectors("wo", wo)
    try:
        shape = np.broadcast_shapes(lights.shape, viewers.shape)
    except ValueError:
        raise InputError(
            f"wi: shape {lights.shape} does not go with {viewers.shape} of wo; expected shapes that broadcast"
        ) from None
    return shape[:-1], rows(np.broadcast_to(lights, shape)), rows(np.broadcast_to(viewers, shape))


def rows(array: Floats) -> Floats:
    """(..., 3) as (N, 3), a view where the strides allow one."""
    return array.reshape(-1, array.shape[-1]) if array.size else np.empty((0, 3), array.dtype)


def last(planes: npt.NDArray[Any], shape: tuple[int, ...]) -> npt.NDArray[Any]:
    """[plane][element] as an array of that shape with the planes last, a view."""
    return np.moveaxis(planes.reshape(planes.shape[:1] + shape), 0, -1)


def number(name: str, value: object, low: float, high: float) -> float:
    """A number in [low, high]."""
    try:
        found = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise InputError(f"{name}: {value!r}; expected a number") from None
    if not low <= found <= high:
        raise InputError(f"{name}: {value!r}; expected a number from {low:g} to {high:g}")
    return found


def whole(name: str, value: object, low: int, high: int) -> int:
    """A whole number in [low, high]."""
    if isinstance(value, bool) or not hasattr(value, "__index__"):
        raise InputError(f"{name}: {value!r}; expected a whole number")
    found = int(value.__index__())
    if not low <= found <= high:
        raise InputError(f"{name}: {found}; expected a whole number from {low} to {high}")
    return found
