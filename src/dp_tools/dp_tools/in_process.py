"""The closed loop without middleware: the cores of all nodes, called in the order in which messages travel.

With h the time step of the simulator and m steps a sample of the control system, the state at t = k h is answered so:

1. if m divides k: pose -> observer -> controller -> allocator -> command; what the allocator achieves goes back to
   observer and controller, for their next step;
2. thruster feedback -> drivers, with the newest command -> actuator setpoints;
3. the simulator steps from t to t + h.

That is the order of the lockstep graph, and headings pass through quaternions as they do in messages: the trajectory is
the same.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any, TypeVar

import numpy as np

from dp_controller import Controller, ControllerInputs, ControllerSettings
from dp_controller.vertical import VerticalInputs, VerticalOutput
from dp_observer import Observer, ObserverEstimate, ObserverInputs, ObserverSettings
from dp_observer.estimate import VerticalEstimate
from dp_tools.node_settings import ALLOCATOR, CONTROLLER, DRIVERS, OBSERVER, SIMULATOR
from dp_tools.planes import PLANE, as_sent, joined, split
from dp_tools.run_data import PROPULSION_TRUTH, RunData, RunInfo
from dp_tools.run_log import RunLog
from dp_tools.scenario import Event, Scenario
from dp_tools.versions import versions
from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.settings import Settings, with_parameters
from thrust_allocator import Allocator, AllocatorSettings
from thruster_drivers import DriverInputs, Drivers, DriverSettings
from vessel_sim import SimulatorInputs, SimulatorSettings, SimulatorTruth, make_simulator

S = TypeVar("S", bound=Settings)

_AT_FEEDBACK = frozenset(
    (
        "shaft_speed",
        "motor_torque",
        "power",
        "azimuth",
        "pitch_ratio",
        "torque_setpoint",
        "azimuth_rate_setpoint",
        "pitch_ratio_setpoint",
        "code",
        "ventilating",
        "beta_q",
        "beta_q2",
    )
)
# Progress is told this often, in control samples.
_PROGRESS_SAMPLES = 50


class ClosedLoop:
    """Sails one scenario in process.

    Parameters
    ----------
    vessel
        The vessel.
    scenario
        Settings at start, events, duration and seed.

    Raises
    ------
    InputError
        If the scenario's parameters are refused or do not fit the vessel.
    """

    def __init__(self, vessel: Vessel, scenario: Scenario) -> None:
        self._vessel = vessel
        self._scenario = scenario
        self._settings = scenario.settings(vessel)
        self._simulator = make_simulator(vessel, self._of(SIMULATOR, SimulatorSettings))
        self._observer = Observer(vessel, self._of(OBSERVER, ObserverSettings))
        self._controller = Controller(vessel, self._of(CONTROLLER, ControllerSettings))
        self._allocator = Allocator(vessel, self._of(ALLOCATOR, AllocatorSettings))
        self._drivers = Drivers(vessel, self._of(DRIVERS, DriverSettings))
        self._apply: dict[str, Callable[[Any], None]] = {
            SIMULATOR: self._simulator.apply,
            OBSERVER: self._observer.apply,
            CONTROLLER: self._controller.apply,
            ALLOCATOR: self._allocator.apply,
            DRIVERS: self._drivers.apply,
        }

        self._step_ns = round(vessel.simulation.time_step * 1e9)
        self._ratio = round(vessel.measurement.sample_time / vessel.simulation.time_step)
        self._ticks = self._tick_at(scenario.duration)
        self._tick = 0
        self._answered: int | None = None  # stamp of the newest pose answered, ns
        self._log = RunLog(vessel, -(-self._ticks // self._ratio), self._ticks, _AT_FEEDBACK)
        n = len(vessel.thrusters)
        self._tau_achieved: FloatArray = np.zeros(3)
        # Of a submerged vehicle: along heave, about roll and pitch.
        self._vertical_achieved: FloatArray | None = np.zeros(3) if vessel.is_submerged else None
        self._thrust: FloatArray = np.zeros(n)
        self._azimuth: FloatArray = np.zeros(n)
        self._command_stamp = 0  # ns
        self._surge: tuple[int, float] | None = None  # stamp (ns) of the last valid estimate, and its surge speed

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self._tick * self._step_ns * 1e-9

    def run(self, progress: Callable[[float], None] = lambda simulated: None) -> RunData:
        """Sail the whole scenario and return what was logged; ``progress`` is told the simulated time (s) now and then.

        Raises
        ------
        InputError
            If a core refuses what an event asks; the message says when.
        """
        started = datetime.now(UTC).isoformat(timespec="seconds")
        begin = time.perf_counter()
        for event in self._scenario.events:
            self._advance(self._tick_at(event.at), progress)
            try:
                self._perform(event)
            except InputError as error:
                raise InputError(f"at {event.at} s: {error}") from error
        self._advance(self._ticks, progress)
        wall_time = time.perf_counter() - begin
        info = RunInfo(
            scenario=self._scenario.name,
            vessel=self._vessel.name,
            how="in process",
            seed=self._scenario.seed,
            versions=versions(),
            started=started,
            simulated_time=self.time,
            wall_time=wall_time,
        )
        return self.data(info)

    def data(self, info: RunInfo) -> RunData:
        """Return what was logged so far."""
        feedback_times: FloatArray = np.arange(self._tick, dtype=np.float64) * self._step_ns * 1e-9
        return self._log.finish(info, feedback_times[:: self._ratio], feedback_times)

    def _controller_time(self, stamp: int) -> float:
        """Return a stamp (ns) on the controller's own clock, which adds up the times between poses."""
        if self._answered is None:
            return stamp * 1e-9
        return self._controller.time + (stamp - self._answered) * 1e-9

    def _of(self, node: str, kind: type[S]) -> S:
        settings = self._settings[node]
        if not isinstance(settings, kind):
            raise TypeError(f"{node}: expected {kind.__name__}, found {type(settings).__name__}")
        return settings

    def _tick_at(self, seconds: float) -> int:
        return round(_nanoseconds(seconds) / self._step_ns)

    def _perform(self, event: Event) -> None:
        """Do what the operator does: parameters first."""
        for node, values in event.parameters.items():
            settings = with_parameters(self._settings[node], values)
            self._apply[node](settings)
            self._settings[node] = settings
        if event.setpoint is not None:
            self._controller.set_setpoint(as_sent(np.array(event.setpoint)))
        if event.joystick is not None:
            time_given = None if self._answered is None else self._controller_time(_nanoseconds(event.at))
            self._controller.set_joystick(np.array(event.joystick), time_given)
        if event.path is not None:
            self._controller.set_path(
                np.array([self._controller_time(_nanoseconds(point.at)) for point in event.path]),
                np.array([as_sent(np.array(point.position)) for point in event.path]),
            )

    def _advance(self, until: int, progress: Callable[[float], None]) -> None:
        """Sail to tick ``until``."""
        simulator, drivers = self._simulator, self._drivers
        ratio, step_ns, step = self._ratio, self._step_ns, self._vessel.simulation.time_step
        rows = self._log.rows
        shaft_speed, motor_torque, power, azimuth = (
            rows["shaft_speed"],
            rows["motor_torque"],
            rows["power"],
            rows["azimuth"],
        )
        torque_setpoint, rate_setpoint = rows["torque_setpoint"], rows["azimuth_rate_setpoint"]
        pitch_ratio, pitch_setpoint = rows["pitch_ratio"], rows["pitch_ratio_setpoint"]
        ventilating, beta_q, beta_q2 = rows["ventilating"], rows["beta_q"], rows["beta_q2"]
        detects = self._vessel.drivers.ventilation is not None
        compensates = self._of(DRIVERS, DriverSettings).needs_speed(self._vessel)
        elapsed = step_ns * 1e-9  # as nodes find it from stamps
        output = simulator.output
        for k in range(self._tick, until):
            phase = k % ratio
            if phase == 0:
                self._control(k)
                if k % (ratio * _PROGRESS_SAMPLES) == 0:
                    progress(k * step_ns * 1e-9)
            shaft_speed[k] = output.shaft_speed
            motor_torque[k] = output.torque
            power[k] = output.power
            azimuth[k] = output.azimuth
            pitch_ratio[k] = output.pitch_ratio
            age = (k * step_ns - self._command_stamp) * 1e-9
            setpoint = drivers.step(
                DriverInputs(
                    self._thrust,
                    self._azimuth,
                    age,
                    output.shaft_speed,
                    output.torque,
                    output.azimuth,
                    output.pitch_ratio,
                    self._surge_speed(k) if compensates else None,
                ),
                elapsed if k else step,
            )
            torque_setpoint[k] = setpoint.torque
            rate_setpoint[k] = setpoint.azimuth_rate
            pitch_setpoint[k] = setpoint.pitch_ratio
            if setpoint.code.size:
                rows["code"][k] = setpoint.code
            if detects:
                ventilating[k] = setpoint.ventilating
                beta_q[k] = setpoint.beta_q
                beta_q2[k] = setpoint.beta_q2
            output = simulator.step(SimulatorInputs(setpoint.torque, setpoint.azimuth_rate, setpoint.pitch_ratio), step)
        self._tick = max(until, self._tick)

    def _surge_speed(self, k: int) -> float | None:
        """Return the surge speed (m/s) that the drivers know at tick ``k``; None if it is stale or none has come."""
        limit = self._of(DRIVERS, DriverSettings).command_timeout or self._vessel.drivers.command_timeout
        if self._surge is None or (k * self._step_ns - self._surge[0]) * 1e-9 > limit:
            return None
        return self._surge[1]

    def _estimate(
        self, now: int, pose: FloatArray | None, elapsed: float
    ) -> tuple[ObserverEstimate, float, int] | None:
        """Return the observer's answer to a pose, the time (s) since the answer before, and its stamp (ns).

        A loop that is disturbed may answer otherwise; None for not at all: the command before stands.
        """
        return self._observer.step(self._observed(pose), elapsed), elapsed, now

    def _observed(self, pose: FloatArray | None) -> ObserverInputs:
        """Return what the observer is given."""
        if pose is None or self._vertical_achieved is None:
            return ObserverInputs(pose, self._tau_achieved, None, self._vertical_achieved)
        plane, below = split(pose)
        return ObserverInputs(plane, self._tau_achieved, below, self._vertical_achieved)

    def _repeat_row(self, i: int) -> None:
        """Log a sample without an answer as the one before it."""
        if i:
            for name, values in self._log.rows.items():
                if name not in _AT_FEEDBACK:
                    values[i] = values[i - 1]

    def _control(self, k: int) -> None:
        """Answer the pose at tick ``k`` with a command."""
        elapsed = self._ratio * self._step_ns * 1e-9 if k else self._vessel.measurement.sample_time
        simulator = self._simulator
        truth = simulator.truth()
        wind = simulator.measure_wind()
        pose = simulator.measure()
        if pose is not None:
            pose = as_sent(pose)
        answered = self._estimate(k * self._step_ns, pose, elapsed)
        if answered is None:
            self._repeat_row(k // self._ratio)
            return
        estimate, elapsed, stamp = answered
        below: VerticalInputs | None = None
        if estimate.vertical is None:
            position = as_sent(estimate.position)
        else:
            position, place = split(as_sent(joined(estimate.position, estimate.vertical.position)))
            below = VerticalInputs(place, estimate.vertical.velocity, self._vertical_achieved)
        demand = self._controller.step(
            ControllerInputs(position, estimate.velocity, self._tau_achieved, estimate.valid, wind, below), elapsed
        )
        tau = demand.tau_desired
        if demand.vertical is not None:
            tau = joined(tau, demand.vertical.tau_desired)[self._vessel.axis_indices]
        settings = self._allocator.settings
        if k and settings.power.needs_measurement:
            power = self._log.rows["power"][k - 1]
            self._allocator.measure_power(float(power[settings.enabled(self._vessel)].sum()))
        if k and settings.needs_direction:
            self._allocator.measure_azimuth(self._log.rows["azimuth"][k - 1])
        if k and settings.antispin.enabled:
            if self._vessel.drivers.ventilation is None:
                raise InputError(
                    f"at {k * self._step_ns * 1e-9:.3f} s: thrust_allocator waits for ventilation, which nobody "
                    "publishes: antispin.enabled is true, and the vessel has no drivers.ventilation"
                )
            # Of the feedback before, as on the graph: the drivers answer that of this tick later.
            self._allocator.measure_ventilation(self._log.rows["beta_q2"][k - 1], self._step_ns * 1e-9)
        if settings.needs_speed and estimate.valid:
            self._allocator.measure_speed(float(estimate.velocity[0]))
        answer = self._allocator.step(tau, elapsed)
        if self._vessel.is_submerged:
            self._tau_achieved, self._vertical_achieved = split(answer.wrench)
        else:
            self._tau_achieved = answer.tau_achieved
        self._thrust, self._azimuth = answer.thrust, answer.azimuth
        self._command_stamp = stamp
        if estimate.valid:
            self._surge = stamp, float(estimate.velocity[0])
        self._answered = k * self._step_ns

        log, rows, i = self._log, self._log.rows, k // self._ratio
        if pose is not None:
            rows["pose"][i] = pose[PLANE] if below is not None else pose
        if wind is not None:
            rows["wind"][i] = wind
        if truth.vertical_position is None:
            rows["truth_position"][i] = as_sent(truth.position + truth.wave_position)
        for name in PROPULSION_TRUTH:
            rows[f"truth_{name}"][i] = getattr(truth, name)
        rows["estimate_position"][i] = position
        rows["estimate_velocity"][i] = estimate.velocity
        rows["wave_position"][i] = estimate.wave_frequency_position
        rows["bias"][i] = estimate.bias
        rows["reference_position"][i] = demand.reference_position
        rows["reference_velocity"][i] = demand.reference_velocity
        rows["proportional"][i] = demand.proportional
        rows["integral"][i] = demand.integral
        rows["derivative"][i] = demand.derivative
        rows["wind_feedforward"][i] = demand.wind_feedforward
        rows["joystick"][i] = demand.joystick
        rows["transfer"][i] = demand.transfer
        rows["tau_desired"][i] = demand.tau_desired
        rows["tau_achieved"][i] = self._tau_achieved
        rows["slack"][i] = answer.slack
        rows["allocation_cost"][i] = answer.cost
        rows["thrust_command"][i] = answer.thrust
        rows["azimuth_command"][i] = answer.azimuth
        if answer.antispin:
            rows["torque_loss"][i] = answer.torque_loss
        rows["minimum_gain"][i] = answer.gains.global_gain
        rows["minimum_gain_both_ways"][i] = answer.gain_both_ways.gain
        if answer.avoidance is not None:
            rows["minimum_gain_free"][i] = answer.avoidance.minimum_gain_free
        rows["performance_measure"][i] = answer.mean_force
        rows["rotating"][i] = answer.rotating
        rows["sub_problem"][i] = 0.0
        if answer.sectors is not None:
            rows["sub_problem"][i] = answer.sectors.sub_problem
            rows["crossing"][i] = answer.sectors.crossing
        if estimate.vertical is not None and below is not None and demand.vertical is not None:
            self._log_below(i, pose, truth, estimate.vertical, below, demand.vertical)
        if answer.method_report is not None:
            for name in ("tau_feasible", "tau_qp", "feasible_load"):
                rows[name][i] = getattr(answer, name)
        t = k * self._step_ns * 1e-9
        log.note("method", t, answer.method)
        log.note("observer_status", t, estimate.status)
        log.note("controller_mode", t, demand.mode)
        log.note("controller_status", t, demand.status)
        log.note("allocation_status", t, answer.status)
        log.note("azimuth_mode", t, answer.azimuth_mode)

    def _log_below(
        self,
        i: int,
        pose: FloatArray | None,
        truth: SimulatorTruth,
        estimate: VerticalEstimate,
        sent: VerticalInputs,
        demand: VerticalOutput,
    ) -> None:
        """Log depth, roll and pitch of a submerged vehicle, and the forces along the other axes."""
        rows = self._log.rows
        if pose is not None:
            rows["vertical_pose"][i] = split(pose)[1]
        if truth.vertical_position is not None:
            place = split(as_sent(joined(truth.position, truth.vertical_position)))
            rows["truth_position"][i], rows["vertical_truth"][i] = place
        rows["vertical_estimate"][i] = sent.position
        rows["vertical_velocity"][i] = estimate.velocity
        rows["vertical_bias"][i] = estimate.bias
        rows["vertical_reference"][i] = demand.reference
        rows["vertical_desired"][i] = demand.tau_desired
        rows["vertical_achieved"][i] = self._vertical_achieved


def _nanoseconds(seconds: float) -> int:
    return round(seconds * 1e9)
