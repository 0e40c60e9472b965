"""What `dp propeller` looks at: one propeller of a vessel, or one from a propeller file."""

from __future__ import annotations

from dataclasses import dataclass

from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.propeller_file import PrintedFigures, PropellerFile
from marine_model.propellers import PropellerModel
from marine_model.ventilation import VentilationData


@dataclass(frozen=True)
class Subject:
    """A propeller with what belongs to it.

    Attributes
    ----------
    name, title
        For files, e.g. 'azimuth_bow', and for headings.
    model
        The propeller.
    density
        kg/m^3.
    pitch_range
        Least and largest P/D of the actuator; None where the pitch is fixed.
    ventilation
        Its loss of thrust to air, if the vessel has data.
    printed
        Figures of a source to show beside ours, if there are any.
    """

    name: str
    title: str
    model: PropellerModel
    density: float
    pitch_range: tuple[float, float] | None
    ventilation: VentilationData | None = None
    printed: PrintedFigures | None = None

    @property
    def knows_advance(self) -> bool:
        """False for a propeller that is known at zero advance alone."""
        return float(self.model.advance_number_end(self.model.pitch_ratio)) > 0.0


def subjects_of(vessel: Vessel, thruster: str = "") -> tuple[Subject, ...]:
    """Return every propeller of ``vessel``, or that of one thruster. Raises InputError for an unknown one."""
    if thruster and thruster not in vessel.thruster_names:
        raise InputError(f"--thruster: expected one of {', '.join(vessel.thruster_names)}, found '{thruster}'")
    return tuple(
        Subject(
            name=one.name,
            title=f"{vessel.name}, {one.name.replace('_', ' ')}",
            model=model,
            density=vessel.density,
            pitch_range=None if one.pitch is None else (one.pitch.min, one.pitch.max),
            ventilation=vessel.ventilation,
        )
        for one, model in zip(vessel.thrusters, vessel.propeller_models, strict=True)
        if thruster in ("", one.name)
    )


def subject_of(propeller: PropellerFile) -> Subject:
    """Return the propeller of a propeller file."""
    return Subject(
        name=propeller.name,
        title=propeller.description,
        model=propeller.propeller.build(),
        density=propeller.density,
        pitch_range=None if propeller.pitch is None else (propeller.pitch.min, propeller.pitch.max),
        printed=propeller.printed,
    )
