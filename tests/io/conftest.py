"""Gmsh, for the tests that write files with it."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from typing import Any

import pytest


@pytest.fixture(scope="module")
def gmsh() -> Iterator[Any]:
    """Gmsh with two cubes that share a face."""
    module = pytest.importorskip("gmsh")
    module.initialize(interruptible=False)
    if hasattr(signal, "SIGPIPE"):
        # Gmsh resets it: a later test whose worker process is lost would end this one.
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    try:
        module.option.setNumber("General.Verbosity", 0)
        module.model.occ.addBox(0, 0, 0, 1, 1, 1)
        module.model.occ.addBox(1, 0, 0, 1, 1, 1)
        module.model.occ.fragment([(3, 1)], [(3, 2)])
        module.model.occ.synchronize()
        module.option.setNumber("Mesh.MeshSizeMax", 0.7)
        yield module
    finally:
        module.finalize()
