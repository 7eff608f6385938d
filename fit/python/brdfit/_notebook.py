"""How a material looks in a notebook."""

from __future__ import annotations

import html
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ._errors import DeviceError

if TYPE_CHECKING:
    from ._material import Material

_ANGLES = 181
_INCIDENCE = math.radians(45)
_SIZE = 320, 170
_COLOURS = {"R": "#c0392b", "G": "#27ae60", "B": "#2980b9"}


def summary(data: dict[str, Any]) -> str:
    """ "lambert + ggx + ggx, R G B"."""
    models = [data["diffuse"]["model"], *(lobe["model"] for lobe in data["lobes"])]
    names = data["channels"]
    return " + ".join(models) + ", " + (" ".join(names) if len(names) <= 4 else f"{len(names)} channels")


def _polar_plot(material: Material) -> str:
    """The lobes in the plane of incidence, light at 45 degrees, radius the fourth root of f."""
    theta = np.linspace(-math.pi / 2, math.pi / 2, _ANGLES)
    wo = np.stack([np.sin(theta), np.zeros_like(theta), np.cos(theta)], axis=-1)
    wi = np.array([-math.sin(_INCIDENCE), 0, math.cos(_INCIDENCE)])
    try:
        values = material.eval(wi, wo, progress=False)
    except DeviceError:
        return ""
    radius = np.maximum(values, 0) ** 0.25
    largest = float(radius.max())
    if not largest > 0:
        return ""
    width, height = _SIZE
    scale = (height - 12) / largest
    lines = []
    for c, name in enumerate(material.channels[:8]):
        x = width / 2 + radius[:, c] * wo[:, 0] * scale
        y = height - 6 - radius[:, c] * wo[:, 2] * scale
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y))
        lines.append(f'<polyline points="{points}" fill="none" stroke="{_COLOURS.get(name, "#555")}"/>')
    light = f'<line x1="{width / 2}" y1="{height - 6}" x2="{width / 2 - height * 0.7:.1f}" y2="{height - 6 - height * 0.7:.1f}" stroke="#999" stroke-dasharray="4"/>'
    ground = f'<line x1="0" y1="{height - 6}" x2="{width}" y2="{height - 6}" stroke="#999"/>'
    return (
        f'<svg width="{width}" height="{height}" role="img" aria-label="lobes at 45 degrees">'
        f"{ground}{light}{''.join(lines)}</svg>"
    )


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list):
        shown = ", ".join(_cell(x) for x in value[:4])
        return shown + (", …" if len(value) > 4 else "")
    return html.escape(str(value))


def material_html(material: Material) -> str:
    """A table of the parts, and the lobes drawn for light at 45 degrees."""
    data = material.to_dict()
    rows = []
    for part in (data["diffuse"], *data["lobes"]):
        strength = part.get("kd", part.get("ks"))
        parameters = "  ".join(
            f"{html.escape(key)} {_cell(value)}" for key, value in part.items() if key not in ("model", "kd", "ks")
        )
        rows.append(
            f"<tr><td>{html.escape(part['model'])}</td><td>{_cell(strength)}</td><td>{parameters}</td></tr>"
        )
    fit = data.get("fit")
    caption = ""
    if fit:
        error = fit.get("error", {}).get(fit.get("metric", ""), None)
        caption = f"<caption>{html.escape(str(fit.get('source', '')))}, {html.escape(str(fit.get('metric', '')))} error {_cell(error)}</caption>"
    names = html.escape(" ".join(data["channels"][:8]))
    return (
        f"<div><table>{caption}<tr><th>model</th><th>kd, ks ({names})</th><th>parameters</th></tr>"
        f"{''.join(rows)}</table>{_polar_plot(material)}</div>"
    )
