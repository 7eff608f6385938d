"""What is rendered, and how."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Union

from . import _brdfit
from ._arrays import floats, number, whole
from ._errors import InputError

#: One number for red, green and blue, or three.
Colour = Union[float, Sequence[float]]

_MOST_SIDE = 8192
_MOST_SAMPLES = 2**24
_MOST_RADIANCE = 1e6


def _colour(name: str, value: Colour, most: float) -> list[float]:
    array = floats(name, value)
    if array.shape not in ((), (3,)):
        raise InputError(f"{name}: shape {array.shape}; expected one number, or three, red, green and blue")
    return [number(name, x, 0, most) for x in (array.tolist() if array.ndim else [array.item()] * 3)]


def _sides(size: int | tuple[int, int]) -> tuple[int, int]:
    if isinstance(size, Sequence):
        if len(size) != 2:
            raise InputError(f"size: {size!r}; expected pixels, or (width, height)")
        return whole("size", size[0], 1, _MOST_SIDE), whole("size", size[1], 1, _MOST_SIDE)
    side = whole("size", size, 1, _MOST_SIDE)
    return side, side


def wishes(
    *,
    shape: str,
    size: int | tuple[int, int],
    samples: int | None,
    environment: str | None,
    lights: Sequence[str],
    turn: float,
    ground: Colour | None,
    backdrop: Colour | None,
    brushed: str,
    view: float | None,
    around: float,
    angle: float,
    bounces: int,
    tolerance: float | None,
    sampling: str,
    seed: int,
) -> _brdfit.RenderWishes:
    """Arguments of Material.render, checked."""
    if isinstance(lights, str) or not all(isinstance(light, str) for light in lights):
        raise InputError("lights: expected a sequence of str, one a light")
    if brushed not in ("around", "along"):
        raise InputError(f"brushed: {brushed!r}; expected 'around' or 'along'")
    around_us = environment if environment is not None else "none" if lights else "softbox"
    for name, given, used, expected in (
        ("ground", ground is not None, shape == "ground", "shape 'ground'"),
        ("turn", turn != 0, around_us != "none", "an environment to turn"),
        ("bounces", bounces != 0, shape == "ground" or ":" in shape, "several shapes: 'ground', 'row:N' or 'grid:CxR'"),
    ):
        if given and not used:
            raise InputError(f"{name}: changes nothing here; expected {expected}")
    wished = _brdfit.RenderWishes()
    wished.shape = shape
    wished.environment = around_us
    wished.lights = list(lights)
    wished.turn = number("turn", turn, -2 * math.pi, 2 * math.pi)
    wished.ground = _colour("ground", 0.5 if ground is None else ground, 1)
    wished.backdrop = [] if backdrop is None else _colour("backdrop", backdrop, _MOST_RADIANCE)
    wished.along = brushed == "along"
    wished.view = None if view is None else number("view", view, 1e-4, math.pi - 1e-4)
    wished.around = number("around", around, -2 * math.pi, 2 * math.pi)
    wished.angle = number("angle", angle, math.radians(1), math.radians(120))
    wished.width, wished.height = _sides(size)
    wished.samples = whole("samples", (64 if tolerance is None else 65536) if samples is None else samples, 1, _MOST_SAMPLES)
    wished.tolerance = None if tolerance is None else number("tolerance", tolerance, 1e-6, 1)
    wished.sampling = sampling
    wished.seed = whole("seed", seed, 0, 2**64 - 1)
    wished.bounces = whole("bounces", bounces, 0, 64)
    return wished
