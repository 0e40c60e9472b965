"""Trial files by name or path."""

from __future__ import annotations

from pathlib import Path

from dp_bringup.workspace import share
from dp_tools.open_water.rig import controllers_of, rig_of
from dp_tools.open_water.trial import Trial
from marine_model.errors import DocumentError
from marine_model.load import with_propeller_data
from marine_model.named_files import file_names, named_file
from marine_model.schema import FieldError
from marine_model.yaml_document import read_yaml


def trial_folder() -> Path:
    """Return the folder of the trials that come with dp_bringup. Raises WorkspaceError if it is not built."""
    return share("dp_bringup") / "open_water"


def trial_names() -> tuple[str, ...]:
    """Return the names of the trials that come with dp_bringup, sorted. Raises WorkspaceError."""
    return file_names(trial_folder())


def load_trial(name_or_path: str | Path) -> Trial:
    """Return a validated trial.

    Parameters
    ----------
    name_or_path
        A name out of ``trial_names()``, or the path of a YAML file (anything with a folder or a suffix).

    Raises
    ------
    UnknownNameError
        If no trial has that name, or the path does not exist.
    DocumentError
        If the file cannot be read or breaks the schema, or propeller, shaft and controllers do not fit together: one
        line per problem, with file, line and field.
    WorkspaceError
        If a name is asked for and dp_bringup is not built.
    """
    document = with_propeller_data(read_yaml(named_file("trial", name_or_path, trial_folder)))
    trial = document.validate(Trial)
    try:
        controllers_of(trial, rig_of(trial))
    except FieldError as error:
        raise DocumentError(document.problem(error.field, str(error))) from error
    return trial
