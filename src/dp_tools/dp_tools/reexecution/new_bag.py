"""What re-execution gave, written as a bag."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from dp_bringup.message_types import message_class
from dp_tools.recorder.bag_metadata import TopicInfo
from dp_tools.recorder.bag_writer import BagWriter
from dp_tools.recorder.quality import describe_quality
from dp_tools.recorder.schemas import full_definition
from dp_tools.reexecution.reexecute import Reexecution
from dp_tools.versions import VERSIONS_RECORD, versions

# Name of the metadata record that says of what the bag is a re-execution.
REEXECUTION_RECORD = "reexecution"
