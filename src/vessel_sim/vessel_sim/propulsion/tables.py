"""Parameters and starting state of the thrusters of a vessel, packed for the compiled step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from marine_model.guards import FloatArray
from marine_model.propulsion import Propulsion
from marine_model.thruster import AzimuthThruster
from marine_model.ventilation import table as ventilation_table
from vessel_sim.propulsion import columns


@dataclass(frozen=True, slots=True)
class PlantTables:
    """Thrusters as rows of numbers; columns are named in ``vessel_sim.propulsion.columns``.

    Rows of propellers and of ventilation are long, and shared by the thrusters that have the same.
    """

    names: tuple[str, ...]
    parameters: FloatArray  # (n, columns.PARAMETERS)
    propellers: FloatArray  # (propellers, width), rows of marine_model.propellers
    ventilation: FloatArray  # (kinds, ventilation.table.WIDTH)
    start: FloatArray  # (n, columns.STATE): at rest, azimuths in their fixed directions, design pitch, no losses

    @classmethod
    def of(cls, vessel: Propulsion) -> Self:
        """Return the tables of ``vessel``, in file order."""
        n = len(vessel.thrusters)
        parameters = np.zeros((n, columns.PARAMETERS))
        start = np.zeros((n, columns.STATE))
        parameters[:, columns.DENSITY] = vessel.density
        parameters[:, columns.PROPELLER] = np.arange(n)
        if vessel.ventilation_row is None:
            ventilation = np.zeros((0, ventilation_table.WIDTH))
            parameters[:, columns.VENTILATION] = -1.0
        else:
            ventilation = vessel.ventilation_row[None].copy()
        for i, (thruster, model) in enumerate(zip(vessel.thrusters, vessel.propeller_models, strict=True)):
            row = parameters[i]
            drive = thruster.shaft
            row[columns.INERTIA] = drive.inertia
            row[columns.VISCOUS] = drive.friction_viscous
            row[columns.STATIC] = drive.friction_static
            row[columns.TORQUE_MAX] = drive.torque_max
            row[columns.DIAMETER] = model.diameter
            if isinstance(thruster, AzimuthThruster):
                row[columns.TURNS] = 1.0
                row[columns.AZIMUTH_RATE_MAX] = thruster.azimuth_drive.rate_max
                row[columns.AZIMUTH_TIME_CONSTANT] = thruster.azimuth_drive.time_constant
            if thruster.pitch is not None:
                row[columns.CONTROLLABLE] = 1.0
                row[columns.PITCH_MIN] = thruster.pitch.min
                row[columns.PITCH_MAX] = thruster.pitch.max
                row[columns.PITCH_RATE_MAX] = thruster.pitch.rate
                row[columns.PITCH_TIME_CONSTANT] = thruster.pitch.time_constant
            start[i, columns.PITCH_RATIO] = model.pitch_ratio
        start[:, columns.AZIMUTH] = vessel.fixed_direction
        for column in (columns.THRUST_WETTED, columns.TORQUE_WETTED, columns.THRUST_LOSS, columns.TORQUE_LOSS):
            start[:, column] = 1.0
        return cls(vessel.thruster_names, parameters, vessel.propeller_table.copy(), ventilation, start)

    def rows(self, which: ArrayLike) -> Self:
        """Return a table of the thrusters with the numbers ``which``, shape (m,), in that order; they may repeat."""
        index = np.asarray(which, dtype=np.intp)
        return type(self)(
            tuple(self.names[i] for i in index.tolist()),
            self.parameters[index],
            self.propellers,
            self.ventilation,
            self.start[index],
        )
