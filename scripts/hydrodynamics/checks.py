"""Conservation laws, reciprocity and limits that hold whatever the hull: what ``--check`` prints."""

from __future__ import annotations

from dataclasses import dataclass

import capytaine as cpt
import numpy as np

from hydrodynamics.body import HEAVE, ROLL, Hull
from hydrodynamics.drift import drift, lost, spent
from hydrodynamics.hull_form import Array
from hydrodynamics.mesh import enclosed
from hydrodynamics.motions import motion, viscous_roll
from hydrodynamics.near_field import fixed_hull_force
from hydrodynamics.solve import DIRECTIONS, Flow, solve

FREQUENCIES = (2.0, 3.5, 5.0)
SHORT = 7.0
HEADINGS: Array = np.radians([0.0, 45.0, 90.0, 135.0, 180.0])


@dataclass(frozen=True)
class Check:
    """One comparison: ``error`` may be at most ``allowed``."""

    name: str
    error: float
    allowed: float

    @property
    def passed(self) -> bool:
        """True if it is not larger."""
        return self.error <= self.allowed

    def __str__(self) -> str:
        return f"{'ok  ' if self.passed else 'FAIL'} {self.error:9.2e} of {self.allowed:.0e}  {self.name}"


def run(hull: Hull) -> int:
    """Print all checks of ``hull``; return 1 if one fails, else 0."""
    solver = cpt.BEMSolver()
    flows = [solve(solver, hull, frequency, -HEADINGS) for frequency in FREQUENCIES]
    found = [
        _volume(hull),
        *(check for flow in flows for check in _of_flow(hull, flow)),
        *_short_waves(hull, solve(solver, hull, SHORT, -HEADINGS)),
        _near_field(solver, hull, flows[1]),
    ]
    for check in found:
        print(check)
    return 0 if all(check.passed for check in found) else 1


def _volume(hull: Hull) -> Check:
    displaced = float(hull.mass[0, 0])
    return Check("panels enclose the displaced volume", abs(enclosed(hull.body.mesh) / displaced - 1.0), 1e-9)


def _of_flow(hull: Hull, flow: Flow) -> list[Check]:
    at = f"at {flow.frequency:g}"
    damping = viscous_roll(hull, float(flow.added_mass[ROLL, ROLL]))
    checks = []
    for name, matrix in (("added mass", flow.added_mass), ("radiation damping", flow.damping)):
        checks.append(Check(f"{name} {at} is symmetric", _difference(matrix, matrix.T), 0.06))
    checks.append(
        Check(f"radiation damping {at} is the energy of the waves", _difference(flow.damping, sent(flow)), 0.1)
    )
    checks.append(Check(f"excitation {at} is what reciprocity (Haskind) says", _haskind(flow), 0.08))
    for name, viscous in (("no viscous damping", 0.0), ("viscous roll damping", damping)):
        moved = motion(hull, flow, viscous)
        error = np.abs(lost(flow, moved, -HEADINGS) - spent(flow, moved, viscous)).max() / hull.form.beam
        checks.append(Check(f"energy {at}, {name}, over that on the beam", float(error), 0.06))
    force = drift(flow, motion(hull, flow, damping), -HEADINGS, damping)
    checks.append(
        Check(f"no sway and yaw in head and following seas {at}", float(np.abs(force[[0, 4], 1:]).max()), 1e-3)
    )
    checks.append(Check(f"no surge and yaw in beam seas {at}", float(np.abs(force[2, [0, 2]]).max()), 1e-3))
    mirrored = force[::-1] * [-1.0, 1.0, -1.0]
    checks.append(Check(f"bow and stern are alike {at}", float(np.abs(force - mirrored).max()), 1e-3))
    return checks


def sent(flow: Flow) -> Array:
    """Return the damping that the waves of unit motion amount to: 4 pi omega times the integral of H_i conj(H_j)."""
    products = np.einsum("id,jd->ij", flow.radiated, flow.radiated.conj()).real
    damping: Array = 4.0 * np.pi * flow.frequency * products * (2.0 * np.pi / len(DIRECTIONS))
    return damping


def _haskind(flow: Flow) -> float:
    """Error of the force from waves as 4 pi / omega times those that motion sends back to where they come from."""
    back = (np.rint(np.degrees(-HEADINGS)).astype(int) + 180) % 360
    radiated = flow.radiated[:, back].T
    # One complex factor, the same for every mode and heading, and known in size.
    factor = np.vdot(radiated, flow.excitation) / np.vdot(radiated, radiated)
    expected = 4.0 * np.pi / flow.frequency
    apart = np.linalg.norm(flow.excitation - factor * radiated) / np.linalg.norm(flow.excitation)
    return max(float(apart), float(abs(abs(factor) / expected - 1.0)))


def _short_waves(hull: Hull, flow: Flow) -> list[Check]:
    """Faltinsen's limit: waves are reflected by the waterline, 1/2 sin^2 of the angle to it, along its normal."""
    xi = np.linspace(0.0, 1.0, 4001)
    n = hull.form.exponent
    slope = hull.form.beam * n * xi ** (n - 1.0)
    force = drift(flow, motion(hull, flow, 0.0), -HEADINGS, 0.0)
    side = 0.5 * np.trapezoid(1.0 / (1.0 + slope**2), xi)
    end = 0.5 * np.trapezoid(slope**3 / (1.0 + slope**2), xi)
    return [
        Check("short beam seas are reflected by the waterline", abs(-force[2, 1] / side - 1.0), 0.1),
        Check("short head seas are reflected by the waterline", abs(-force[4, 0] / end - 1.0), 0.2),
        Check("heave in short waves vanishes", float(np.abs(motion(hull, flow, 0.0)[:, HEAVE]).max()), 0.02),
    ]


def _near_field(solver: cpt.BEMSolver, hull: Hull, flow: Flow) -> Check:
    far = drift(flow, np.zeros((len(HEADINGS), 6), dtype=np.complex128), -HEADINGS, 0.0)[-1, 0]
    near = fixed_hull_force(solver, hull, flow.frequency, -float(HEADINGS[-1]))[0]
    return Check(
        f"force on the hull held in head seas at {flow.frequency:g}, from pressure", abs(near / far - 1.0), 0.05
    )


def _difference(a: Array, b: Array) -> float:
    """Largest difference of two matrices over the geometric mean of the diagonal elements of its row and column."""
    size = np.sqrt(np.abs(np.diag(a)))
    return float((np.abs(a - b) / np.outer(size, size)).max())
