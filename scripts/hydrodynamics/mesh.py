"""Panels of a quarter of the hull and of the water surface inside it, mirrored twice."""

from __future__ import annotations

from dataclasses import replace
from math import ceil
from typing import Any

import capytaine as cpt
import numpy as np
from scipy.optimize import brentq

from hydrodynamics.hull_form import Array, HullForm


def panel_counts(form: HullForm, panel: float) -> tuple[int, int, int]:
    """Return how many panels of side ``panel`` (m): along a quarter, round half a section, across half the lid."""
    along = ceil(0.5 * (form.length + 0.6 * form.beam) / panel)
    return along, ceil((0.5 * form.beam + form.draught) / panel), ceil(0.5 * form.beam / panel)


def hull_and_lid(form: HullForm, panel: float) -> tuple[cpt.ReflectionSymmetricMesh, cpt.ReflectionSymmetricMesh]:
    """Return the panels of the wetted hull and of its inner water surface.

    The lid keeps the solution unique at the frequencies at which water inside the hull would slosh.
    """
    along, around, across = panel_counts(form, panel)
    stations = form.stations(along)
    sections = [form.section(float(xi), around) for xi in stations]
    x = 0.5 * form.length * stations
    hull = np.array([[(x[i], y, z) for y, z in zip(*section, strict=True)] for i, section in enumerate(sections)])
    breadth = np.linspace(1.0, 0.0, across + 1)
    lid = np.array([[(x[i], half * s, 0.0) for s in breadth] for i, half in enumerate(form.half_breadth(stations))])
    return _mirrored(hull, "hull"), _mirrored(lid, "lid")


def fitted(form: HullForm, panel: float, volume: float) -> HullForm:
    """Return the form with ``fining`` such that its panels enclose ``volume`` (m^3)."""

    def excess(fining: float) -> float:
        return enclosed(hull_and_lid(replace(form, fining=fining), panel)[0]) - volume

    span = 0.2 * max(form.fining, 0.1)
    return replace(form, fining=float(brentq(excess, form.fining - span, form.fining + span, xtol=1e-13)))


def enclosed(mesh: cpt.ReflectionSymmetricMesh) -> float:
    """Return the volume between panels and calm surface, m^3."""
    return float(np.sum(mesh.faces_centers[:, 2] * mesh.faces_normals[:, 2] * mesh.faces_areas))


def _mirrored(grid: Array, name: str) -> cpt.ReflectionSymmetricMesh:
    """Return the panels of a grid of points, shape (rows, columns, 3), in the quarter ahead and to port."""
    rows, columns = grid.shape[:2]
    points, same = np.unique(grid.reshape(-1, 3).round(12), axis=0, return_inverse=True)
    index = same.reshape(rows, columns)
    # In this order the normals point out of the hull, and down from the lid.
    corners = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    # A panel with a side of no length is a triangle.
    faces = [list(dict.fromkeys(int(v) for v in face)) for face in corners]
    quarter = Panels(points, [face for face in faces if len(face) > 2], auto_clean=False, auto_check=False, name=name)
    half = cpt.ReflectionSymmetricMesh(quarter, plane="xOz")
    return cpt.ReflectionSymmetricMesh(half, plane="yOz")


class Panels(cpt.Mesh):
    """Panels whose mirror images are exact although they are twisted.

    The centre of a panel that is not plane depends on which diagonal it is folded along, and capytaine's own
    mirror images are folded along the other one: the hull is not quite symmetric then, which in long waves, where
    the inertia of yaw is small against the forces that cancel, shows.
    """

    def mirrored(self, plane: str, *, name: str | None = None) -> Panels:
        """Return the mirror image, folded along the same diagonals."""
        other = super().mirrored(plane, name=name)
        return _panels(other, [face[-1:] + face[:-1] for face in other.as_list_of_faces()])

    def join_meshes(*meshes: cpt.Mesh, return_masks: bool = False, **words: Any) -> Any:
        """Join meshes as capytaine does, into ``Panels``."""
        found = cpt.Mesh.join_meshes(*meshes, return_masks=return_masks, **words)
        mesh, *masks = found if return_masks else (found,)
        joined = _panels(mesh, mesh.as_list_of_faces())
        return (joined, *masks) if return_masks else joined


def _panels(mesh: cpt.Mesh, faces: list[list[list[float]]]) -> Panels:
    found: Panels = Panels.from_list_of_faces(
        faces, faces_metadata=mesh.faces_metadata, name=mesh.name, auto_clean=False, auto_check=False
    )
    return found
