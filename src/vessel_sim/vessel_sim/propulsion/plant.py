"""The propulsion plant of a vessel: all thrusters in one compiled step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NoReturn, Self

import numpy as np

from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.vessel import Vessel
from vessel_sim.propulsion import columns
from vessel_sim.propulsion.shared_step import Spread, advance_shared
from vessel_sim.propulsion.step import GOOD, first_bad
from vessel_sim.propulsion.tables import PlantTables


class PropulsionPlant:
    """Motors, shafts, propellers, azimuth and pitch actuators of n thrusters.

    Stopped shafts, azimuths in their fixed directions, design pitch and no loss at the start.

    Parameters
    ----------
    vessel
        The vessel whose thrusters they are. ``from_tables`` takes any rows.

    Attributes
    ----------
    ventilation
        False: propellers lose nothing to air, from the next step on. Where a vessel has no section ``ventilation``
        they never do.
    spread
        Runs a function at the same time in as many threads as it has, and returns when all are done: more than 1,000
        thrusters are shared among them. None: the thread of the caller works alone. Results are the same.
    """

    def __init__(self, vessel: Vessel) -> None:
        self._set_up(PlantTables.of(vessel))

    @classmethod
    def from_tables(cls, tables: PlantTables) -> Self:
        """Return a plant of the thrusters in ``tables``."""
        plant = cls.__new__(cls)
        plant._set_up(tables)
        return plant

    def _set_up(self, tables: PlantTables) -> None:
        self.ventilation = True
        self.spread: Spread | None = None
        self._names = tables.names
        # Copies: writable and contiguous, so that there is one compiled version of the step.
        self._tables: tuple[FloatArray, FloatArray, FloatArray] = (
            np.array(tables.parameters, order="C"),
            np.array(tables.propellers, order="C"),
            np.array(tables.ventilation, order="C"),
        )
        self._drives = self._tables[0][:, [columns.TORQUE_MAX, columns.AZIMUTH_RATE_MAX]]  # without failures
        self._state: FloatArray = np.array(tables.start, order="C")
        self._shape = (len(self._names),)
        self._inputs: FloatArray = np.zeros((columns.INPUTS, *self._shape))  # in force
        self._inputs[columns.PITCH_INPUT] = self._state[:, columns.PITCH_RATIO]
        self._given = self._inputs.copy()  # not looked at yet
        self._flooded = False

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the thrusters."""
        return self._names

    @property
    def parameters(self) -> FloatArray:
        """Parameters, shape (n, ``columns.PARAMETERS``)."""
        return self._tables[0]

    @property
    def state(self) -> FloatArray:
        """State, shape (n, ``columns.STATE``): a view that the next step changes."""
        return self._state

    def fail(self, motors: Sequence[bool], azimuths: Sequence[bool]) -> None:
        """Say which thrusters have failed from the next step on; all others work, those repaired included.

        A motor that has failed gives no torque: its propeller turns as the water makes it. An azimuth motor that has
        failed gives no rate: it comes to rest within its own time constant, and the thruster stays where it points.

        Parameters
        ----------
        motors, azimuths
            One element a thruster; empty for none. A thruster that does not turn has no azimuth motor to fail.

        Raises
        ------
        InputError
            If the number of elements is another; nothing has changed then.
        """
        n = len(self._names)
        for name, failed in (("motors", motors), ("azimuths", azimuths)):
            if len(failed) not in (0, n):
                raise InputError(f"{name}: expected {n} elements or none, found {len(failed)}")
        for j, (column, failed) in enumerate(((columns.TORQUE_MAX, motors), (columns.AZIMUTH_RATE_MAX, azimuths))):
            works = np.ones(n) if not len(failed) else 1.0 - np.array(failed, dtype=np.float64)
            self.parameters[:, column] = works * self._drives[:, j]

    def flood(self, advance_speed: FloatArray, submergence: FloatArray) -> None:
        """Say what the water at the propellers is now, before the first step; otherwise the first step tells.

        Parameters
        ----------
        advance_speed
            V_A, m/s, shape (n,).
        submergence
            h, m, shape (n,).

        Raises
        ------
        InputError
            As :meth:`step`.
        """
        still = np.zeros(self._shape)
        self.step(still, still, None, advance_speed, submergence, 0.0)

    def step(
        self,
        torque: FloatArray,
        azimuth_rate: FloatArray,
        pitch_ratio: FloatArray | None,
        advance_speed: FloatArray,
        submergence: FloatArray,
        dt: float,
    ) -> None:
        """Advance ``state`` by ``dt``. Arrays have shape (n,).

        Parameters
        ----------
        torque
            Motor torque, N m, held over the step; the motor limits it.
        azimuth_rate
            rad/s, held over the step; the servo limits it, a thruster that does not turn ignores it.
        pitch_ratio
            P/D, held over the step; the actuator keeps it in its range. None: the last set point stays.
        advance_speed
            V_A at the end of the step, m/s: speed through the water along the direction of positive thrust.
        submergence
            h at the end of the step, m: depth of the shaft below the surface.
        dt
            s, at least 0.

        Raises
        ------
        InputError
            If a shape is wrong, a number is not finite, ``dt`` is negative or not finite, or a propeller of fixed
            pitch is asked for another than its own; nothing has moved then.
        """
        self._take_set_points(torque, azimuth_rate, pitch_ratio)
        self._take_water(advance_speed, submergence)
        self._move(dt)

    def command(
        self, torque: FloatArray, azimuth_rate: FloatArray, pitch_ratio: FloatArray | None
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        """Take set points as :meth:`step` does, for a compiled step that finds out about the water itself.

        Only shapes are looked at. Once the set points have been found good, :meth:`accept` puts them in force;
        otherwise :meth:`refuse` says what is wrong.

        Returns
        -------
        Parameters, propellers, ventilation, state, inputs not looked at yet, inputs in force: see ``sail``.

        Raises
        ------
        InputError
            If a shape is wrong.
        """
        self._take_set_points(torque, azimuth_rate, pitch_ratio)
        return (*self._tables, self._state, self._given, self._inputs)

    def check_pitch(self, pitch_ratio: FloatArray) -> None:
        """Refuse what :meth:`step` would refuse as ``pitch_ratio``.

        Raises
        ------
        InputError
            As :meth:`step`.
        """
        self._given[:] = self._inputs
        self._take(columns.PITCH_INPUT, pitch_ratio)
        bad = first_bad(
            self.parameters, self._state, self._given, self._inputs, columns.PITCH_INPUT, columns.PITCH_INPUT + 1
        )
        if bad != GOOD:
            self.refuse(bad)

    def _take_set_points(self, torque: FloatArray, azimuth_rate: FloatArray, pitch_ratio: FloatArray | None) -> None:
        self._take(columns.TORQUE_INPUT, torque)
        self._take(columns.AZIMUTH_RATE_INPUT, azimuth_rate)
        if pitch_ratio is None:
            self._given[columns.PITCH_INPUT] = self._inputs[columns.PITCH_INPUT]
        else:
            self._take(columns.PITCH_INPUT, pitch_ratio)

    def _take_water(self, advance_speed: FloatArray, submergence: FloatArray) -> None:
        self._take(columns.ADVANCE_SPEED_INPUT, advance_speed)
        self._take(columns.SUBMERGENCE_INPUT, submergence)

    def _take(self, row: int, value: FloatArray) -> None:
        shape = getattr(value, "shape", None)
        if shape != self._shape:
            name = columns.INPUT_NAMES[row]
            raise InputError(f"{name}: expected shape {self._shape}, found {shape or value!r}")
        self._given[row] = value

    def _move(self, dt: float) -> None:
        if not 0.0 <= dt < math.inf:
            raise InputError(f"dt: expected a finite number not below 0, found {dt}")
        if not self._flooded:
            self._state[:, columns.ADVANCE_SPEED] = self._given[columns.ADVANCE_SPEED_INPUT]
            self._state[:, columns.SUBMERGENCE] = self._given[columns.SUBMERGENCE_INPUT]
        bad = advance_shared(self.spread, self._tables, self._state, self._given, self._inputs, 0, self.ventilation, dt)
        if bad != GOOD:
            self.refuse(bad)
        self._flooded = True
        self.accept()

    def accept(self) -> None:
        """Put in force what :meth:`command` took."""
        self._inputs, self._given = self._given, self._inputs

    def refuse(self, bad: int) -> NoReturn:
        """Raise for the number of an input, row times n plus column; see ``step.first_bad``.

        Raises
        ------
        InputError
            As :meth:`step`.
        """
        row, i = divmod(bad, len(self._names))
        name, thruster, found = columns.INPUT_NAMES[row], self._names[i], float(self._given[row, i])
        if not math.isfinite(found):
            raise InputError(f"{name}: expected finite numbers, found {found} for thruster '{thruster}'")
        own = float(self._state[i, columns.PITCH_RATIO])
        raise InputError(f"{name}: thruster '{thruster}' has a fixed pitch, expected {own}, found {found}")
