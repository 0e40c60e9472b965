"""Was the demand within what Theorem 7.3 of [Ruth] says can be had, and was it met?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from dp_tools.run_data import RunData
from marine_model import Vessel
from marine_model.guards import FloatArray
from thrust_allocator.singularity import scaled_configuration, scaling_of

# How hard thrusters push astern, as far as the minimum gain goes: as hard as ahead, as the theorem has it; as hard as
# the vessel file says; azimuth thrusters that rotate not at all.
Reverse = Literal["as_ahead", "own", "none"]
# Missed force that counts, scaled as (7.6): 0.09 N on CyberShip III. The constraint is soft; without any limit it
# leaves 0.0006 at most of a demand of length sigma_min (40000 random directions, sigma_min from 0.001).
MISSED = 0.01


@dataclass(frozen=True, slots=True)
class Attainable:
    """The demand of every sample beside the minimum gain, all scaled as [Ruth] (7.6) and so without dimension.

    Parameters
    ----------
    t
        Time, shape (k,), s.
    demand, commanded
        Length of the desired and of the commanded generalized force, shape (k,).
    missed
        Length of their difference, shape (k,).
    gain
        Minimum gain sigma_min at the directions of the sample: the largest demand that (7.76) promises, shape (k,).
    change
        Length of what the demand differs from what the thrusts of the sample before would give along the directions
        of this one, shape (k,).
    change_allowed
        The largest change that thrusts of limited rate certainly follow, by (7.15), shape (k,).
    """

    t: FloatArray
    demand: FloatArray
    commanded: FloatArray
    missed: FloatArray
    gain: FloatArray
    change: FloatArray
    change_allowed: FloatArray

    @property
    def beyond(self) -> NDArray[np.bool_]:
        """Samples in which the theorem promises nothing, shape (k,)."""
        return self.demand > self.gain

    @property
    def too_fast(self) -> NDArray[np.bool_]:
        """Samples within the theorem's ball that ask for more change than thrusts may make, shape (k,).

        The theorem knows limits of thrust, not of its rate.
        """
        return ~self.beyond & (self.change > self.change_allowed)

    @property
    def inside(self) -> NDArray[np.bool_]:
        """The others: what was asked for must be there, shape (k,)."""
        return ~self.beyond & ~self.too_fast

    def within(self, start: float, end: float) -> Attainable:
        """Return the part with start <= t < end (s)."""
        # As Series.window.
        first, last = np.searchsorted(self.t, [start - 5e-7, end - 5e-7])
        part = slice(int(first), int(last))
        return Attainable(
            self.t[part],
            self.demand[part],
            self.commanded[part],
            self.missed[part],
            self.gain[part],
            self.change[part],
            self.change_allowed[part],
        )


def attainable(run: RunData, vessel: Vessel, reverse: Reverse = "as_ahead") -> Attainable:
    """Return the demands of a whole run beside what Theorem 7.3 of [Ruth] promises.

    Parameters
    ----------
    run
        The run.
    vessel
        Its vessel.
    reverse
        How hard thrusters push astern. With ``own`` every thruster counts with the weaker of its two limits, so that
        the theorem's proof holds for limits that differ; thrusters that are lost are not looked for there.

    Raises
    ------
    InputError
        If a series is missing: minimum gains are there only where the allocator was told to watch them.
    """
    scaling = scaling_of(vessel)
    scale = np.array([1.0, 1.0, 1.0 / scaling.typical_arm]) / scaling.mean_thrust_max
    desired, commanded = run["tau_desired"], run["tau_achieved"]
    t = desired.t
    thrust, azimuth = run["thrust_command"], run["azimuth_command"].at(t)
    gain = _gain(run, vessel, azimuth, t, reverse)
    # Thrusts of the sample before, along the directions of this one; none before the first.
    before = np.vstack([np.zeros((1, thrust.values.shape[1])), thrust.at(t)[:-1]])
    x, y = before * np.cos(azimuth), before * np.sin(azimuth)
    force = np.column_stack([x.sum(axis=1), y.sum(axis=1), (vessel.lever_x * y - vessel.lever_y * x).sum(axis=1)])
    elapsed = vessel.measurement.sample_time
    share = float((vessel.thrust_rate * elapsed / vessel.thrust_max).min())
    return Attainable(
        t,
        _length(desired.values * scale),
        _length(commanded.at(t) * scale),
        _length((desired.values - commanded.at(t)) * scale),
        gain,
        _length((desired.values - force) * scale),
        share * gain,
    )


def _gain(run: RunData, vessel: Vessel, azimuth: FloatArray, t: FloatArray, reverse: Reverse) -> FloatArray:
    if reverse != "own":
        name = "minimum_gain" if reverse == "none" else "minimum_gain_both_ways"
        gains: FloatArray = run[name].at(t)[:, 0]
        return gains
    weaker = np.minimum(vessel.thrust_max, -vessel.thrust_min) / vessel.thrust_max
    scaling = scaling_of(vessel)
    known: dict[bytes, float] = {}  # held directions come again and again
    found = np.empty(len(t))
    for i, angles in enumerate(azimuth):
        key = angles.tobytes()
        if key not in known:
            matrix = scaled_configuration(scaling, angles) * weaker
            known[key] = float(np.linalg.svd(matrix, compute_uv=False)[-1])
        found[i] = known[key]
    return found


def _length(vectors: FloatArray) -> FloatArray:
    lengths: FloatArray = np.linalg.norm(vectors, axis=1)
    return lengths
