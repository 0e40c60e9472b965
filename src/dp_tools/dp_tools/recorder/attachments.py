"""Files that go with a bag, so that it can be understood by itself."""

from __future__ import annotations

import yaml

from marine_model import Vessel

VESSEL_ATTACHMENT = "vessel.yaml"
SCENARIO_ATTACHMENT = "scenario.yaml"


def vessel_document(vessel: Vessel) -> bytes:
    """Return a vessel as one YAML file; whole, as a vessel file may extend another."""
    return yaml.safe_dump(vessel.model_dump(mode="json"), sort_keys=False).encode()


def parameters_attachment(node: str) -> str:
    """Return the name of the attachment with the parameters of a node, given its full name."""
    return f"parameters/{node.strip('/')}.yaml"
