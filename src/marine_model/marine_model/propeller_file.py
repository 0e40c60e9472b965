"""A propeller by itself: a file with the propeller section of a vessel, to look at with `dp propeller`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, model_validator

from marine_model.load import with_propeller_data
from marine_model.named_files import file_names, named_file
from marine_model.propellers.sections import PropellerData
from marine_model.schema import NonNegative, Positive, Section
from marine_model.thruster import check_pitch
from marine_model.yaml_document import read_yaml, validate

PROPELLER_FOLDER = Path(__file__).parent / "propeller_files"

# Largest absolute and relative loss of efficiency.
Losses = Annotated[tuple[NonNegative, NonNegative], Field(strict=False)]


class PitchRange(Section):
    """What the pitch actuator reaches."""

    min: float  # P/D
    max: float  # P/D

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.min >= self.max:
            raise ValueError(f"pitch.min must be below pitch.max, found {self.min} and {self.max}")
        return self


class PrintedFigures(Section):
    """What a source prints about the propeller, to be shown beside what is computed."""

    source: str
    polynomials: str  # which ones the source uses
    thrust_coefficient: Positive  # K_T at J = 0 and the design pitch ratio
    torque_coefficient: Positive  # K_Q there
    bollard_pitch_ratio: Positive  # best P/D at J = 0
    best_loading: Positive  # tau of the largest efficiency
    best_pitch_ratio: Positive  # P/D there
    full_pitch_loading: Positive  # tau from which the largest pitch ratio is best
    full_pitch_torque_coefficient: Positive  # best K_Q there
    least_error_torque_coefficient: Positive  # K_Qc of the least relative loss
    torque_pitch: Losses
    torque_shaft_speed: Losses
    largest_pitch: Losses
    design_pitch: Losses


class PropellerFile(Section):
    """One propeller file."""

    name: str = Field(min_length=1)
    description: str
    density: Positive  # kg/m^3
    propeller: PropellerData
    pitch: PitchRange | None = None  # a controllable-pitch propeller; none when absent
    printed: PrintedFigures | None = None

    @model_validator(mode="after")
    def _pitch_is_known(self) -> Self:
        if self.pitch is not None:
            check_pitch(self.propeller, self.pitch.min, self.pitch.max)
        return self


def propeller_names() -> tuple[str, ...]:
    """Return the names of the propellers that come with this package, sorted."""
    return file_names(PROPELLER_FOLDER)


def load_propeller(name_or_path: str | Path) -> PropellerFile:
    """Return a validated propeller.

    Parameters
    ----------
    name_or_path
        A name out of ``propeller_names()``, or the path of a YAML file (anything with a folder or a suffix).

    Raises
    ------
    UnknownNameError
        If no propeller has that name, or the path does not exist.
    DocumentError
        If the file cannot be read or breaks the schema: one line per problem, with file, line and field.
    """
    path = named_file("propeller", name_or_path, lambda: PROPELLER_FOLDER)
    document = with_propeller_data(read_yaml(path))
    return validate(document.content, PropellerFile, document)
