"""Impact of two AO models under a power law by Exudyn, if that package is installed.

    pip install exudyn;  python benchmarks/adaptive.py

adaptive.py starts this program and exchanges lines of JSON with it. In: the scene, then any number
of runs [integrator, steps, tolerance], a tolerance of 0 meaning fixed steps. Out, after "result ",
one line per run: best time of the solver's call in s, peak force, velocity of the projectile's
contact coordinate at the end, steps; or the reason of a failure.

Each AO model is one GenericODE2 object; the contact is a coordinate spring whose force is a
symbolic user function, so that no Python is called while it runs. Indentation and its rate are
recorded at every step; the peak is that of a cubic interpolation of both between adjacent steps.
"""

from __future__ import annotations

import json
import math
import sys
import time
from typing import Any

import numpy as np


def body_matrices(star: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    m, k = np.array(star["m"]), np.array(star["k"])
    mass = np.diag(np.concatenate([[star["m0"]], m]))
    stiffness = np.diag(np.concatenate([[star["k0"] + k.sum()], k]))
    stiffness[0, 1:] = stiffness[1:, 0] = -k
    return mass, stiffness


def add_body(mbs: Any, item: Any, star: dict[str, Any], velocity: float) -> tuple[int, int]:
    """Add a body; return its node, and the marker of its contact coordinate."""
    mass, stiffness = body_matrices(star)
    n = len(mass)
    node = mbs.AddNode(
        item.NodeGenericODE2(
            numberOfODE2Coordinates=n,
            referenceCoordinates=[0.0] * n,
            initialCoordinates=[0.0] * n,
            initialCoordinates_t=[velocity] * n,
        )
    )
    mbs.AddObject(
        item.ObjectGenericODE2(nodeNumbers=[node], massMatrix=mass, stiffnessMatrix=stiffness)
    )
    return node, mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=0))


def build(scene: dict[str, Any]) -> tuple[Any, Any, list[int], list[int]]:
    import exudyn as exu
    import exudyn.itemInterface
    from exudyn.utilities import CreateSymbolicUserFunction

    item = exu.itemInterface

    container = exu.SystemContainer()
    mbs = container.AddSystem()
    markers, nodes = [], []
    for star, velocity in zip(scene["bodies"], (scene["velocity"], 0.0), strict=True):
        node, marker = add_body(mbs, item, star, velocity)
        nodes.append(node)
        markers.append(marker)
    # The connector's displacement is the target's minus the projectile's: minus the indentation.
    contact = mbs.AddObject(
        item.ObjectConnectorCoordinateSpringDamper(
            markerNumbers=markers, stiffness=scene["k"], damping=0.0
        )
    )
    symbolic, exponent = exu.symbolic, scene["exponent"]

    def force(mbs, t, itemNumber, displacement, velocity, stiffness, damping, offset):
        depth = symbolic.max(-displacement, 0.0)
        if exponent == 1.5:
            return -stiffness * depth * symbolic.sqrt(depth)
        return -stiffness * symbolic.pow(depth, exponent)

    function = CreateSymbolicUserFunction(
        mbs, function=force, itemIndex=contact, userFunctionName="springForceUserFunction"
    )
    mbs.SetObjectParameter(contact, "springForceUserFunction", function)
    sensors = [
        mbs.AddSensor(
            item.SensorObject(
                objectNumber=contact, writeToFile=False, storeInternal=True, outputVariableType=kind
            )
        )
        for kind in (exu.OutputVariableType.Displacement, exu.OutputVariableType.Velocity)
    ]
    mbs.Assemble()
    return exu, mbs, sensors, nodes


def settings(exu: Any, scene: dict[str, Any], steps: int, tolerance: float) -> Any:
    made = exu.SimulationSettings()
    made.timeIntegration.endTime = scene["duration"]
    made.timeIntegration.numberOfSteps = steps
    made.timeIntegration.automaticStepSize = tolerance > 0.0
    made.timeIntegration.minimumStepSize = 1e-16
    made.timeIntegration.verboseMode = 0
    if tolerance > 0.0:
        made.timeIntegration.relativeTolerance = tolerance
        made.timeIntegration.absoluteTolerance = tolerance * scene["length"]
    no_output(made)
    return made


def no_output(made: Any) -> None:
    """Record sensors at every step, without files; the names changed with about version 1.10."""
    if hasattr(made.solution, "sensors"):
        made.solution.file.write = False
        made.solution.sensors.writePeriod = 0.0
        made.solution.solverInformationFileName = ""
    else:
        made.solutionSettings.writeSolutionToFile = False
        made.solutionSettings.sensorsWritePeriod = 0.0


def peak(t: np.ndarray, depth: np.ndarray, rate: np.ndarray) -> float:
    """Return the peak depth, from cubics through the depth and rate of adjacent samples."""
    best = float(depth.max())
    for i in np.flatnonzero((rate[:-1] > 0.0) & (rate[1:] <= 0.0)):
        h, slope = t[i + 1] - t[i], (depth[i + 1] - depth[i]) / (t[i + 1] - t[i])
        a = (rate[i] + rate[i + 1] - 2.0 * slope) / h**2
        b = (3.0 * slope - 2.0 * rate[i] - rate[i + 1]) / h
        root = math.sqrt(max(b * b - 3.0 * a * rate[i], 0.0))
        s = -rate[i] / (b - root)
        best = max(best, float(depth[i] + s * (rate[i] + s * (b + s * a))))
    return best


def run(scene: dict[str, Any], integrator: str, steps: int, tolerance: float) -> dict[str, Any]:
    exu, mbs, sensors, nodes = build(scene)
    solver = getattr(exu.DynamicSolverType, integrator)
    best, spent, done = math.inf, 0.0, 0
    while done < 1 or (spent < 0.3 and done < 20):
        chosen = settings(exu, scene, steps, tolerance)
        start = time.perf_counter()
        mbs.SolveDynamic(chosen, solverType=solver)
        taken = time.perf_counter() - start
        best, spent, done = min(best, taken), spent + taken, done + 1
    depth, rate = (np.array(mbs.GetSensorStoredData(sensor)) for sensor in sensors)
    deepest = peak(depth[:, 0], -depth[:, 1], -rate[:, 1])
    velocity = np.atleast_1d(mbs.GetNodeOutput(nodes[0], exu.OutputVariableType.Coordinates_t))
    return {
        "seconds": best,
        "peak_force": scene["k"] * deepest ** scene["exponent"],
        "rebound_velocity": float(velocity[0]),
        "steps": len(depth) - 1,
    }


def main() -> None:
    scene = json.loads(sys.stdin.readline())
    for line in sys.stdin:
        integrator, steps, tolerance = json.loads(line)
        try:
            answer = run(scene, integrator, steps, tolerance)
        except Exception as error:  # this setting fails, whatever the reason
            answer = {"failure": f"{type(error).__name__}: {error}"}
        print("result " + json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
