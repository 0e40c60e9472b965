"""The thruster of a trial, once for each case, as the plant, the controllers and the detection take thrusters."""

from __future__ import annotations

from dp_tools.open_water.case import Case
from dp_tools.open_water.trial import Trial
from marine_model.errors import InputError
from marine_model.gains import AzimuthGains, DriverGains, Measurement, PitchGains, Simulation
from marine_model.propulsion import Propulsion
from marine_model.schema import FieldError
from marine_model.shaft_limits import check_shaft_limits
from marine_model.thruster import TunnelThruster
from thruster_drivers.controllers import ThrusterController, Tuning, make_controller, needs_pitch, tuning_of
from thruster_drivers.shaft_model import ShaftModel, shaft_models

# A thruster of a trial neither turns nor gets its command from elsewhere; no controller reads these.
_NO_AZIMUTH = AzimuthGains(quadratic_gain=1.0, linear_gain=1.0, threshold=1.0, rate_per_step=1.0)
_NO_TIMEOUT = 1.0


def rig_of(trial: Trial) -> Propulsion:
    """Return one thruster for each case, in the order of the file.

    Raises
    ------
    FieldError
        If motor or shaft cannot give the largest thrust; it blames a field of the trial.
    """
    thrusters = tuple(_thruster(trial, case) for case in trial.cases)
    try:
        check_shaft_limits(thrusters, [t.propeller.build() for t in thrusters], trial.density)
    except FieldError as error:
        raise FieldError(error.field[2:], f"{error} (case '{trial.cases[int(error.field[1])].name}')") from error
    gains = trial.gains
    return Propulsion(
        name=trial.name,
        density=trial.density,
        thrusters=thrusters,
        drivers=DriverGains(
            shaft_speed=gains.shaft_speed,
            power=gains.power,
            combined=gains.combined,
            torque_shaft_speed=gains.torque_shaft_speed,
            azimuth=_NO_AZIMUTH,
            command_timeout=_NO_TIMEOUT,
            ventilation=gains.ventilation,
        ),
        measurement=Measurement(
            sample_time=trial.time_step,
            position_noise=0.0,
            heading_noise=0.0,
            shaft_speed_noise=trial.shaft_speed_noise,
            azimuth_noise=0.0,
            dropout=0.0,
        ),
        simulation=Simulation(time_step=trial.time_step),
        ventilation=trial.ventilation,
    )


def _thruster(trial: Trial, case: Case) -> TunnelThruster:
    propeller = trial.propeller
    if case.pitch_ratio is not None:
        propeller = propeller.model_copy(update={"pitch_ratio": case.pitch_ratio})
    return TunnelThruster(
        type="tunnel",
        name=case.name,
        position=(0.0, 0.0, 0.0),
        direction=0.0,
        thrust=trial.limits,
        propeller=propeller,
        # Laws that leave the pitch alone are given a propeller of fixed pitch.
        pitch=trial.pitch if needs_pitch(case.controller) else None,
        shaft=trial.shaft,
    )


def controllers_of(trial: Trial, rig: Propulsion) -> tuple[ThrusterController, ...]:
    """Return a controller for each case.

    Raises
    ------
    FieldError
        If the gains of a case do not suit the propeller; it blames the case.
    """
    found = []
    for i, (case, model) in enumerate(zip(trial.cases, shaft_models(rig), strict=True)):
        try:
            found.append(make_controller(case.controller, model, _tuning(trial, rig, case)))
        except InputError as error:
            raise FieldError(("cases", i, "controller"), str(error)) from error
    return tuple(found)


def _tuning(trial: Trial, rig: Propulsion, case: Case) -> Tuning:
    changes = {name: section for name, section in iter(case.gains) if section is not None}
    if case.shaft_speed is not None:
        changes["pitch"] = PitchGains(shaft_speed=(case.shaft_speed,))
    return tuning_of(rig.drivers.model_copy(update=changes), 0)


def held_thrust(case: Case, model: ShaftModel) -> float | None:
    """Return the thrust (N) that a case asks for because it holds one shaft speed; None if it follows the trial's."""
    return model.thrust(case.shaft_speed) if case.holds_speed and case.shaft_speed is not None else None
