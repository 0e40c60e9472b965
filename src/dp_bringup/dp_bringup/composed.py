"""All nodes of the graph in one process, on one executor: `ros2 run dp_bringup composed`."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable

from dp_bringup.workspace import RING_PACKAGES, SIMULATOR_PACKAGE
from dp_node import DpNode, run_nodes
from marine_model.errors import DpError


def node_factory(package: str) -> Callable[[], DpNode]:  # type: ignore[type-arg]
    """Return the class of the node of ``package``: the one subclass of DpNode in its module ``node``.

    Looked up by name, as an executable is: nothing here depends on a node.
    """
    module = importlib.import_module(f"{package}.node")
    found = [
        value
        for value in vars(module).values()
        if isinstance(value, type) and issubclass(value, DpNode) and value.__module__ == module.__name__
    ]
    if len(found) != 1:
        raise DpError(f"{module.__name__}: expected one node class, found {len(found)}")
    return found[0]


def main() -> None:
    """Run the nodes of the packages named on the command line (default: the whole graph)."""
    arguments = sys.argv[1:]
    if "--ros-args" in arguments:
        arguments = arguments[: arguments.index("--ros-args")]
    known = (*RING_PACKAGES, SIMULATOR_PACKAGE)
    unknown = sorted(set(arguments) - set(known))
    if unknown:
        sys.exit(f"composed: expected packages out of {', '.join(known)}, found {', '.join(unknown)}")
    chosen = arguments or known
    sys.exit(run_nodes([node_factory(package) for package in chosen]))
