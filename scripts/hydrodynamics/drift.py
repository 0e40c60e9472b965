"""Mean second-order force from the momentum that the waves carry away (Maruo 1960, Newman 1967).

With H the Kochin function of all waves that go out, in a train of unit amplitude that travels towards beta, and units
of L, rho and g, in deep water:

    X = E cos(beta) - 2 pi k^2 integral |H|^2 cos(theta) d theta,     Y with sin for cos
    N = 2 pi omega / k Re H'(beta) - 2 pi k integral Im(conj(H) H') d theta
    E = -2 pi omega Im H(beta)

E is what the train loses, as momentum. What goes out and what viscous damping takes account for it (optical theorem):

    E = 2 pi k^2 integral |H|^2 d theta + k P / omega,     P the mean power that damping takes

The second form of E is used. H has its largest lobe around beta, the shadow of the hull, which cancels out of X and Y
exactly with it, but only to the error of the panels with the first; the difference of the two measures that error.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrodynamics.body import ROLL
from hydrodynamics.hull_form import Array
from hydrodynamics.solve import DIRECTIONS, ComplexArray, Flow


def waves_out(flow: Flow, motion: ComplexArray) -> ComplexArray:
    """Return H of the moving hull at ``DIRECTIONS``, shape (nh, nd)."""
    return 1j * (flow.diffracted + motion @ flow.radiated)


def drift(flow: Flow, motion: ComplexArray, directions: Array, viscous_roll: float) -> Array:
    """Return X, Y, N in capytaine's axes, shape (nh, 3).

    ``directions`` are those of the waves (rad, whole degrees), ``motion`` the response to them, shape (nh, 6), with
    ``viscous_roll`` added to the damping of roll.
    """
    h = waves_out(flow, motion)
    slope = _derivative(h)
    omega, k = flow.frequency, flow.frequency**2
    lost = spent(flow, motion, viscous_roll)
    x = lost * np.cos(directions) - 2.0 * np.pi * k**2 * _integral(np.abs(h) ** 2 * np.cos(DIRECTIONS))
    y = lost * np.sin(directions) - 2.0 * np.pi * k**2 * _integral(np.abs(h) ** 2 * np.sin(DIRECTIONS))
    ahead = slope[np.arange(len(directions)), _places(directions)]
    n = 2.0 * np.pi * (omega / k * ahead.real - k * _integral((np.conj(h) * slope).imag))
    return np.stack([x, y, n], axis=-1)


def spent(flow: Flow, motion: ComplexArray, viscous_roll: float) -> Array:
    """Return E, shape (nh,), from what goes out and what damping takes."""
    out = 2.0 * np.pi * flow.frequency**4 * _integral(np.abs(waves_out(flow, motion)) ** 2)
    power = 0.5 * viscous_roll * flow.frequency**2 * np.abs(motion[:, ROLL]) ** 2
    return out + flow.frequency * power


def lost(flow: Flow, motion: ComplexArray, directions: Array) -> Array:
    """Return E, shape (nh,), from the amplitude in the direction of the waves."""
    ahead = waves_out(flow, motion)[np.arange(len(directions)), _places(directions)]
    return -2.0 * np.pi * flow.frequency * ahead.imag


def _places(directions: Array) -> NDArray[np.intp]:
    return np.rint(np.degrees(directions)).astype(np.intp) % len(DIRECTIONS)


def _integral(values: Array) -> Array:
    """Integral over all directions, of a function that is periodic in them."""
    total: Array = np.sum(values, axis=-1) * (2.0 * np.pi / len(DIRECTIONS))
    return total


def _derivative(h: ComplexArray) -> ComplexArray:
    """Derivative by direction, from the Fourier series."""
    order = np.fft.fftfreq(len(DIRECTIONS), 1.0 / len(DIRECTIONS))
    return np.fft.ifft(1j * order * np.fft.fft(h, axis=-1), axis=-1)
