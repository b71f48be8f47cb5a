"""Errors said of sensors, against all modes of the full matrices.

The truth shares no code with the package: SciPy's eigenvectors of K and M, each mode propagated
exactly under a force that is straight between steps, and the contact solved by Newton at each step.
Reactions follow from the rows of the held nodes, filtered accelerations from SciPy's Butterworth
filter. `python tools/sensor_errors.py` takes some minutes; docs/theory/errors.md has its figures.
"""

from __future__ import annotations

import warnings
from collections import defaultdict
from typing import Any

import numpy as np
import scipy.linalg
from scipy.signal import butter, sosfilt

import aoimpact as ao
from aoimpact.fem import stiffness_mass
from aoimpact.fields import motion_rows, place_rows

STEEL, ALUMINIUM = ao.Material(210e9, 0.3, 7800), ao.Material(70e9, 0.33, 2700)
MASS, UP = 0.03, (0.0, 0.0, 1.0)
CLASSES = (1000.0, 4000.0)
ENDS = [("xmin", "xyz"), ("xmax", "xyz")]

# Mesh, material, supports, damping; contact, sensors, the supports that are read, and k, N/m^1.5.
BODIES = {
    "plate": (
        (((0.1, 0.08, 0.01), (6, 5, 1)), ALUMINIUM, ENDS, (0.0, 0.0)),
        ((0.05, 0.042, 0.01), [(0.03, 0.04, 0.0), (0.08, 0.06, 0.0)], "xmin", 3e9),
    ),
    "thin plate": (
        (((0.2, 0.15, 0.004), (10, 8, 1)), STEEL, ENDS[:1], (0.0, 0.0)),
        ((0.11, 0.07, 0.004), [(0.15, 0.09, 0.0), (0.05, 0.06, 0.0)], "xmin", 3e9),
    ),
    "beam": (
        (((0.4, 0.02, 0.02), (24, 1, 1)), STEEL, ENDS[:1], (0.0, 0.0)),
        ((0.37, 0.01, 0.02), [(0.2, 0.01, 0.0), (0.1, 0.01, 0.0)], "xmin", 2e9),
    ),
    "block": (
        (((0.05, 0.04, 0.03), (5, 4, 3)), STEEL, [("zmin", "xyz")], (0.0, 0.0)),
        ((0.02, 0.02, 0.03), [(0.04, 0.02, 0.03), (0.02, 0.01, 0.03)], "zmin", 1e10),
    ),
    "damped plate": (
        (((0.15, 0.1, 0.006), (9, 6, 1)), ALUMINIUM, ENDS, (100.0, 1e-6)),
        ((0.07, 0.045, 0.006), [(0.1, 0.045, 0.0), (0.03, 0.06, 0.0)], "xmin", 3e9),
    ),
}


class Truth:
    """All modes of a body, and their motion under a mass at 1 m/s on F = k δ^1.5."""

    def __init__(self, body: ao.FEModel, b: np.ndarray, damping: tuple[float, float]) -> None:
        omega2, self.modes = scipy.linalg.eigh(body.K.toarray(), body.M.toarray())
        self.omega2, self.push = omega2, self.modes.T @ b
        self.decay = 0.5 * (damping[0] + damping[1] * omega2)

    def run(self, k: float, duration: float, dt: float) -> None:
        n, steps = len(self.omega2), round(duration / dt)
        rate = np.zeros((n, 4, 4))  # q, q', the force, and its rise in a step
        rate[:, 0, 1] = rate[:, 1, 2] = 1.0
        rate[:, 1, 0], rate[:, 1, 1], rate[:, 2, 3] = -self.omega2, -2.0 * self.decay, 1.0 / dt
        over = np.array([scipy.linalg.expm(dt * of) for of in rate])
        by_q, by_v = over[:, :2, 0], over[:, :2, 1]
        by_first = (over[:, :2, 2] - over[:, :2, 3]) * self.push[:, None]
        by_last = over[:, :2, 3] * self.push[:, None]
        give = float(self.push @ by_last[:, 0]) + dt * dt / 6.0 / MASS
        self.q, self.v = np.zeros((steps + 1, n)), np.zeros((steps + 1, n))
        self.force, x, speed = np.zeros(steps + 1), 0.0, 1.0
        for i in range(steps):
            before = self.force[i]
            state = by_q * self.q[i, :, None] + by_v * self.v[i, :, None] + by_first * before
            x += dt * speed - dt * dt / 3.0 / MASS * before
            depth, now = x - float(self.push @ state[:, 0]), 0.0
            for _ in range(50 if depth > 0.0 else 0):
                left = max(depth - give * now, 0.0)
                change = (now - k * left**1.5) / (1.0 + 1.5 * give * k * left**0.5)
                now -= change
                if abs(change) <= 1e-13 * abs(now):
                    break
            state += by_last * now
            self.q[i + 1], self.v[i + 1] = state.T
            x -= dt * dt / 6.0 / MASS * now
            speed -= 0.5 * dt * (before + now) / MASS
            self.force[i + 1] = now
        self.t = dt * np.arange(steps + 1)
        self.a = self.push * self.force[:, None] - 2.0 * self.decay * self.v - self.omega2 * self.q

    def of(self, rows: np.ndarray, rate: int = 0) -> np.ndarray:
        return np.asarray((self.q, self.v, self.a)[rate] @ (self.modes.T @ rows))

    def filtered(self, rows: np.ndarray, cfc: float) -> np.ndarray:
        """From second differences of the displacement; NaN over the last period of the class."""
        dt, pole = float(self.t[1]), 2.0775 * cfc
        acceleration = np.diff(np.concatenate([[0.0], self.of(rows), [0.0]]), 2) / dt**2
        acceleration[-1] = 0.0
        still = np.zeros(int(4.0 / pole / dt))
        once = butter(2, pole, fs=1.0 / dt, output="sos")
        smooth = np.concatenate([still, acceleration, still])
        for _ in range(2):
            smooth = sosfilt(once, smooth)[::-1]
        smooth = smooth[len(still) : -len(still)]
        return np.where(self.t <= self.t[-1] - 2.1 / pole, smooth, np.nan)


def models(tip: ao.ContactPoint, contact: float, duration: float) -> dict[str, Any]:
    krylov = {"method": "krylov", "contact_time": contact}
    chosen = {f"chosen to {rtol:g}": (tip, {"rtol": rtol}) for rtol in (5e-4, 2e-3, 1e-2, 5e-2)}
    short = {f"AO {n}": (ao.antioscillators(tip, n, **krylov), {}) for n in (4, 8, 16, 32, 48)}
    long = {
        f"long {n}": (ao.antioscillators(tip, n, duration=duration, **krylov), {})
        for n in (8, 16, 32)
    }
    of_modes = {f"modal {n}": (ao.modal(tip, n), {}) for n in (10, 20)}
    return chosen | short | long | of_modes | {"paper's 10": (ao.antioscillators(tip, 10), {})}


def ratios(name: str) -> dict[str, list[float]]:
    """The error said over the true one, of each sensor and model, where that is above 1e-4."""
    (box, material, fixed, damping), (place, _, _, k) = BODIES[name]
    body = ao.FEModel.from_mesh(
        ao.box_mesh(*box, kind="hexahedron20"),
        material,
        fixed=fixed,
        damping=ao.Rayleigh(alpha=damping[0], beta=damping[1]) if any(damping) else None,
    )
    assert body.mesh is not None
    assert body.nodes is not None
    tip = body.contact(point=place, direction=(0.0, 0.0, -1.0), radius=0)
    truth = Truth(body, tip.b, damping)
    truth.run(k, 1.2e-3, 2e-7)
    contact = float(truth.t[np.flatnonzero(truth.force)[-1]])
    truth.run(k, max(6.0 * contact, 3e-3), min(2e-7, contact / 500.0))
    shown = np.unique(np.linspace(0, len(truth.t) - 1, 1200).astype(int))
    right = true_readings(name, body, truth)
    found = defaultdict(list)
    for model, given in models(tip, contact, float(truth.t[-1])).values():
        options = given or {"solver": ao.Adaptive(rtol=1e-6)}
        law = ao.PowerLaw(k, 1.5)
        hit = ao.simulate(
            ao.rigid(mass=MASS), model, 1.0, law=law, duration=float(truth.t[-1]), **options
        )
        times = np.minimum(truth.t[shown], hit.duration)
        for sensor, (mine, said) in readings(name, body, hit.target, times).items():
            true = right[sensor][shown]
            off = float(np.nanmax(np.abs(mine - true)) / np.nanmax(np.abs(true)))
            if off > 1e-4:
                kind = sensor if sensor == "reaction" else sensor.rpartition(" ")[0]
                found[kind].append(float(np.nanmax(said)) / off)
    return found


def gauge_length(body: ao.FEModel) -> float:
    return float(np.ptp(body.nodes[:, 0])) / 40.0


def true_readings(name: str, body: ao.FEModel, truth: Truth) -> dict[str, np.ndarray]:
    """The true history of each sensor."""
    (_, material, _, damping), (_, sensors, held, _) = BODIES[name]
    stiffness, inertia = (of.tocsr() for of in stiffness_mass(body.mesh, material))
    nodes = body.mesh.node_sets[held]
    lift = np.zeros(stiffness.shape[0])
    lift[3 * nodes + 2] = 1.0
    by_q, by_a = ((lift @ of)[body.free] for of in (stiffness, inertia))
    right = {"reaction": truth.of(by_q) + damping[1] * truth.of(by_q, 1) + truth.of(by_a, 2)}
    length = gauge_length(body)

    def rows(at: Any, axis: Any) -> np.ndarray:
        weights = place_rows(body, np.atleast_2d(at))
        return np.asarray(motion_rows(body, weights, np.atleast_2d(axis)).toarray()[0])

    for i, at in enumerate(sensors):
        up = rows(at, UP)
        right[f"displacement {i}"], right[f"velocity {i}"] = truth.of(up), truth.of(up, 1)
        ends = [rows(at + np.array([side * length / 2.0, 0.0, 0.0]), (1, 0, 0)) for side in (-1, 1)]
        right[f"gauge {i}"] = truth.of((ends[1] - ends[0]) / length)
        for cfc in CLASSES:
            right[f"CFC {cfc:g} {i}"] = truth.filtered(up, cfc)
    return right


def readings(
    name: str, body: ao.FEModel, of: Any, t: np.ndarray
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """What each sensor of a result reads, and the error that it says."""
    _, (_, sensors, held, _) = BODIES[name]
    reaction, length = of.reaction(held, times=t), gauge_length(body)
    read = {"reaction": (reaction.force[:, 2], reaction.error["force"])}
    for i, at in enumerate(sensors):
        probe, gauge = of.probe(at, UP, times=t), of.gauge(at, (1, 0, 0), length, times=t)
        for kind in ("displacement", "velocity"):
            read[f"{kind} {i}"] = getattr(probe, kind), probe.error[kind]
        read[f"gauge {i}"] = gauge.strain, gauge.error
        for cfc in CLASSES:
            channel = probe.filtered(cfc=cfc)
            read[f"CFC {cfc:g} {i}"] = channel.acceleration, channel.error
    return read


def main() -> None:
    warnings.simplefilter("ignore", ao.AOImpactWarning)
    every = defaultdict(list)
    for name in BODIES:
        for kind, of in ratios(name).items():
            every[kind] += of
    print(
        "| sensor | models | within the error said | within twice | said / true (median) | least |"
    )
    print("|---|---|---|---|---|---|")
    for kind, values in sorted(every.items()):
        of = np.array(values)
        within, twice = (100.0 * (of >= least).mean() for least in (1.0, 0.5))
        print(
            f"| {kind} | {len(of)} | {within:.0f} % | {twice:.0f} % | {np.median(of):.2g} "
            f"| {of.min():.2g} |"
        )


if __name__ == "__main__":
    main()
