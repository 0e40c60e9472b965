"""Numbers of `dp propeller`: curves, maps and comparisons of one propeller, each a table of named columns."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from dp_tools.propeller.subject import Subject
from marine_model.constants import GRAVITY
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.propellers.conversion import efficiency
from marine_model.propellers.loading import BestPoint, best_point, largest_loading, power_coefficient
from marine_model.propellers.optimal import advance_number, optimal_pitch, pitch_of_thrust_coefficient
from marine_model.propellers.optimal import efficiency as efficiency_at
from marine_model.propellers.zero_thrust import last_advance_number
from marine_model.root import rising_root
from marine_model.ventilation.static import VentilationModel
from thruster_drivers.sensitivity import Sensitivity, closed_form, nominal_coefficients
from thruster_drivers.sensitivity import efficiency as controllers

_POINTS = 181  # of every curve
_MAP_PITCHES = 91
# [Ruth] Figure 2.10's ranges, a little beyond: everything ventilates at the far end.
_FROUDE = np.linspace(0.0, 4.0, 161)
_SUBMERGENCE = np.linspace(-1.0, 3.0, 161)[1:]

Columns = Mapping[str, FloatArray]


@dataclass(frozen=True)
class Summary:
    """Figures of one propeller; None where they are not defined."""

    diameter: float  # m
    pitch_ratio: float
    pitch_range: tuple[float, float] | None
    thrust_coefficient: float  # at J = 0 and the design pitch ratio
    torque_coefficient: float
    power_per_thrust_3_2: float  # W/N^(3/2)
    bollard_pitch_ratio: float | None  # best P/D at J = 0
    advance_number_end: float  # up to which the model has data or thrust, design pitch ratio
    largest_loading: float  # tau there
    best: BestPoint | None


@dataclass(frozen=True)
class Comparison:
    """One row in the manner of [Ruth] Table 3.3."""

    name: str
    absolute: float
    relative: float
    printed: tuple[float, float] | None = None


@dataclass(frozen=True)
class Study:
    """All numbers of one propeller.

    Attributes
    ----------
    tables
        Columns by name of table; those of a map are flat. What is not defined for the propeller is missing.
    missing
        What is missing, and why, for the reader.
    paths
        (tau, P/D) and efficiency of the consolidated controllers.
    sensitivities
        Sensitivity functions by controller, over J.
    comparisons
        Largest loss of efficiency of every controller.
    torque_coefficients
        K_Qc by name, as in [Ruth] Figure 3.9.
    full_pitch_loading
        tau from which the largest pitch ratio is the best; None where it never is.
    """

    subject: Subject
    summary: Summary
    last_loading: float
    tables: dict[str, Columns] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)
    paths: dict[str, controllers.Path] = field(default_factory=dict)
    sensitivities: dict[str, Sensitivity] = field(default_factory=dict)
    comparisons: tuple[Comparison, ...] = ()
    torque_coefficients: dict[str, float] = field(default_factory=dict)
    full_pitch_loading: float | None = None


def study(subject: Subject, last_loading: float) -> Study:
    """Return the numbers of ``subject``, with tau from 0 to ``last_loading`` where tau is the variable.

    Raises
    ------
    InputError
        If ``last_loading`` is not above 0.
    """
    check_loading(last_loading)
    summary = _summary(subject)
    found = Study(subject, summary, min(last_loading, summary.largest_loading))
    if subject.knows_advance:
        found.tables["open_water"] = _open_water(subject)
        found.sensitivities.update(_sensitivities(subject))
    else:
        why = "the propeller is known at zero advance alone"
        found.missing["open-water curves"] = found.missing["sensitivity functions"] = why
    if subject.pitch_range is None:
        found.missing["efficiency over (tau, P/D), g, h, k, m, torque/shaft-speed control"] = "the pitch is fixed"
    else:
        found = _with_maps(found, subject.pitch_range)
    if subject.ventilation is None:
        found.missing["ventilation maps"] = "there are no ventilation data"
    else:
        found.tables["ventilation"] = _ventilation(VentilationModel(subject.ventilation))
    return found


def check_loading(last_loading: float) -> None:
    """Raise InputError if tau cannot end there."""
    if not (math.isfinite(last_loading) and last_loading > 0.0):
        raise InputError(f"--tau: expected a number above 0, found {last_loading:g}")


def _summary(subject: Subject) -> Summary:
    model = subject.model
    K_T, K_Q = nominal_coefficients(model)
    scale = math.sqrt(subject.density) * model.diameter
    best: BestPoint | None = None
    if subject.knows_advance:
        try:
            best = best_point(model, subject.pitch_range or (model.pitch_ratio, model.pitch_ratio))
        except InputError:
            best = None  # efficiency still rises where the data end
    return Summary(
        diameter=model.diameter,
        pitch_ratio=model.pitch_ratio,
        pitch_range=subject.pitch_range,
        thrust_coefficient=K_T,
        torque_coefficient=K_Q,
        power_per_thrust_3_2=float(power_coefficient(K_T, K_Q)) / scale,
        bollard_pitch_ratio=(
            None if subject.pitch_range is None else float(optimal_pitch(model, 0.0, subject.pitch_range))
        ),
        advance_number_end=float(last_advance_number(model)),
        largest_loading=float(largest_loading(model)),
        best=best,
    )


def _pitches(subject: Subject) -> FloatArray:
    """Return the pitch ratios of the open-water curves: tenths within the range, and its ends."""
    if subject.pitch_range is None:
        return np.array([subject.model.pitch_ratio])
    low, high = subject.pitch_range
    tenths = np.arange(math.ceil(low * 10.0 - 1e-9), math.floor(high * 10.0 + 1e-9) + 1) / 10.0
    return np.unique(np.round(np.concatenate([[low], tenths, [high]]), 9))


def _open_water(subject: Subject) -> Columns:
    pitch = _pitches(subject)[:, np.newaxis]
    J = last_advance_number(subject.model, pitch) * np.linspace(0.0, 1.0, _POINTS)
    pitch = np.broadcast_to(pitch, J.shape)
    K_T, K_Q = subject.model.coefficients(J, pitch)
    eta = efficiency(J, K_T, K_Q)
    columns = {"pitch_ratio": pitch, "J": J, "K_T": K_T, "K_Q": K_Q, "efficiency": eta}
    return {name: np.asarray(values).ravel() for name, values in columns.items()}


def _with_maps(found: Study, pitch_range: tuple[float, float]) -> Study:
    model, summary, printed = found.subject.model, found.summary, found.subject.printed
    tau = found.last_loading * np.linspace(0.0, 1.0, _POINTS)
    pitch = np.linspace(*pitch_range, _MAP_PITCHES)
    grid_tau, grid_pitch = (values.ravel() for values in np.meshgrid(tau, pitch, indexing="ij"))
    found.tables["efficiency"] = {
        "tau": grid_tau,
        "pitch_ratio": grid_pitch,
        "efficiency": efficiency_at(model, grid_tau, grid_pitch),
    }
    best = controllers.best_path(model, tau, pitch_range)
    J = advance_number(model, tau, best.pitch_ratio)
    K_T, K_Q = model.coefficients(J, best.pitch_ratio)
    found.tables["optimal"] = {
        "tau": tau,
        "pitch_ratio": best.pitch_ratio,
        "h": K_Q / K_T,
        "m": 1.0 / np.sqrt(K_T),
        "K_Q": K_Q,
        "efficiency": best.efficiency,
    }
    try:
        K_Td, ratio = pitch_of_thrust_coefficient(model, pitch_range)
        found.tables["pitch_for_thrust"] = {"K_Td": K_Td, "pitch_ratio": ratio}
    except InputError as error:
        found.missing["g(K_Td)"] = str(error)
    full = _full_pitch_loading(found.subject, tau, best.pitch_ratio, pitch_range)
    at_rest = float(K_Q[0])
    least = controllers.least_error_torque_coefficient(model, tau, pitch_range)
    found.torque_coefficients.update({"best at rest": at_rest, "least error": least})
    if full is not None:
        found.torque_coefficients["full pitch"] = float(controllers.best_torque_coefficient(model, full, pitch_range))
    paths = found.paths
    paths["optimal"] = best
    paths["torque/pitch"] = controllers.torque_pitch(model, tau, pitch_range=pitch_range)
    # Its true tau lies below tau_d: start further out, and keep what is in range.
    demanded = controllers.torque_pitch_from_demand(
        model, np.linspace(0.0, 1.5, 3 * _POINTS // 2) * tau[-1], None, pitch_range
    )
    paths["torque/pitch, thrust as demanded"] = demanded.up_to(tau[-1])
    for name, K_Qc in found.torque_coefficients.items():
        paths[f"torque/shaft speed, {name}"] = controllers.torque_shaft_speed(model, tau, K_Qc, pitch_range)
    fixed = {"largest pitch": pitch_range[1], "design pitch": model.pitch_ratio}
    if summary.bollard_pitch_ratio is not None:
        fixed["best pitch at rest"] = summary.bollard_pitch_ratio
    for name, value in fixed.items():
        paths[f"fixed, {name}"] = controllers.fixed_pitch(model, tau, value, pitch_range)
    beside = {}
    if printed is not None:
        beside = {
            "torque/pitch": printed.torque_pitch,
            "torque/shaft speed, least error": printed.torque_shaft_speed,
            "fixed, largest pitch": printed.largest_pitch,
            "fixed, design pitch": printed.design_pitch,
        }
    rows = tuple(
        Comparison(name, path.absolute, path.relative, beside.get(name))
        for name, path in paths.items()
        if name != "optimal"
    )
    return replace(found, comparisons=rows, full_pitch_loading=full)


def _full_pitch_loading(
    subject: Subject, tau: FloatArray, best: FloatArray, pitch_range: tuple[float, float]
) -> float | None:
    """Return the tau from which the largest pitch ratio is best, to 1/40 of a step of ``tau``; None if none is."""
    at = np.flatnonzero(best >= pitch_range[1] - 1e-9)
    if not at.size:
        return None
    between = np.linspace(tau[max(at[0] - 1, 0)], tau[at[0]], 41)
    full = optimal_pitch(subject.model, between, pitch_range) >= pitch_range[1] - 1e-9
    return float(between[np.flatnonzero(full)[0]])


def _sensitivities(subject: Subject) -> dict[str, Sensitivity]:
    """Return the sensitivities of every controller that the propeller can have, [Ruth] Figures 3.10-3.13."""
    model, pitch_range = subject.model, subject.pitch_range
    ratio = model.pitch_ratio
    J = float(last_advance_number(model, ratio)) * np.linspace(0.0, 1.0, _POINTS)
    laws: dict[str, Callable[[FloatArray], Sensitivity]] = {
        "shaft speed": partial(closed_form.shaft_speed, model, pitch_ratio=ratio),
        "torque": partial(closed_form.torque, model, pitch_ratio=ratio),
        "power": partial(closed_form.power, model, pitch_ratio=ratio),
    }
    found = {name: law(J) for name, law in laws.items()}
    if pitch_range is None:
        return found
    share = np.linspace(0.0, 1.0, _POINTS)
    for name, value in (("pitch, least", pitch_range[0]), ("pitch, largest", pitch_range[1])):
        found[name] = closed_form.pitch(model, float(last_advance_number(model, value)) * share, value)
    ratios = np.linspace(*pitch_range, _MAP_PITCHES)
    found["pitch, end of thrust"] = closed_form.pitch(model, last_advance_number(model, ratios), ratios)
    best = float(optimal_pitch(model, 0.0, pitch_range))
    K_Tc, K_Qc = nominal_coefficients(model, best)
    # Up to where the pitch saturates: beyond that it is torque control at the largest pitch.
    high = pitch_range[1]
    end = float(rising_root(lambda j: K_Qc - model.coefficients(j, high)[1], 0.0, last_advance_number(model, high)))
    found["torque/shaft speed"] = closed_form.torque_shaft_speed(model, end * share, K_Qc, K_Tc)
    return found


def _ventilation(model: VentilationModel) -> Columns:
    """Return beta_T and beta_Q over F_nh2 and h/R, [Ruth] Figure 2.10."""
    froude, depth = (values.ravel() for values in np.meshgrid(_FROUDE, _SUBMERGENCE, indexing="ij"))
    # Any diameter and pitch do: the losses depend on F_nh2 and h/R alone, (2.36).
    losses = model.loss_factors(froude * np.sqrt((1.0 + depth) * GRAVITY), 1.0, 1.0, depth)
    return {"F_nh2": froude, "h_over_R": depth, "beta_T": losses.thrust, "beta_Q": losses.torque}
