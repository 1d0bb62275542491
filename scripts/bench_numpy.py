#!/usr/bin/env python3
"""What numpy takes for the same work on one core: separation, fit, and the least squares of a diagnosis.

    OPENBLAS_NUM_THREADS=1 python3 scripts/bench_numpy.py

The separation is the rigid method alone, without covariance, of many IMUs at once (numpy's best case) and of one. The fit is weighted
least squares with covariance of a campaign's three gyros. For a diagnosis only its least squares are counted: every
candidate column of a catalogue of 24, alone, on all dwells and on five held-out folds; no pairs, no intervals, no
words. Medians of seven rounds.
"""
import json
import time

import numpy as np

CAMPAIGN = "tests/data/practice/campaign-00.json"
CANDIDATES = 24
FOLDS = 5


def timed(work, repeats):
    rounds = []
    for _ in range(7):
        begun = time.perf_counter()
        for _ in range(repeats):
            work()
        rounds.append((time.perf_counter() - begun) / repeats)
    return sorted(rounds)[3]


def separate(e, g, nominal, spin):
    """D_I, D_S, D_O of each row: the nominal triad turned by the smallest rotation that takes the input axis to E/|E|."""
    scale = np.linalg.norm(e, axis=1, keepdims=True)
    u, y = e / scale, g / scale
    v = np.cross(nominal, u)
    c = np.sum(nominal * u, axis=1, keepdims=True)

    def turned(a):
        return a * c + np.cross(v, a) + v * np.sum(v * a, axis=1, keepdims=True) / (1 + c)

    output = np.cross(nominal, spin)
    return np.stack([np.sum(y * axis, axis=1) for axis in (u, turned(spin), turned(output))], axis=1)


def main():
    campaign = json.load(open(CAMPAIGN))
    dwells = campaign["dwells"]
    a = np.array([d["specific_force_g0"] for d in dwells])
    w = np.array([d["rate_arcsec_s"] for d in dwells])
    y = np.array([d["output_pulse_s"] for d in dwells])
    sem = np.array([d["output_sem_pulse_s"] for d in dwells])
    # P_x + P_y + P_z = 0, put in: the last square is a difference.
    design = np.column_stack([np.ones(len(a)), a, a[:, :2] ** 2 - a[:, 2:] ** 2, w])

    def fit():
        for j in range(3):
            white, rhs = design / sem[:, j : j + 1], y[:, j] / sem[:, j]
            q, r = np.linalg.qr(white)
            np.linalg.solve(r, q.T @ rhs)
            inverse = np.linalg.inv(r)
            inverse @ inverse.T

    rng = np.random.default_rng(1)
    extra = rng.normal(size=(CANDIDATES, len(a)))
    folds = [np.arange(len(a)) % FOLDS != k for k in range(FOLDS)]

    def diagnose():
        for j in range(3):
            white, rhs = design / sem[:, j : j + 1], y[:, j] / sem[:, j]
            for column in extra:
                wider = np.column_stack([white, column])
                np.linalg.lstsq(wider, rhs)
                for kept in folds:
                    found = np.linalg.lstsq(wider[kept], rhs[kept])[0]
                    np.sum((rhs[~kept] - wider[~kept] @ found) ** 2)

    axes = np.array([[1 / 3**0.5, -1 / 6**0.5, 1 / 2**0.5]]), np.array([[0, 3**0.5 / 2, 0.5]])
    for imus in (1, 10_000):
        nominal, spin = (np.repeat(axis, 3 * imus, axis=0) for axis in axes)
        e = nominal + rng.normal(scale=1e-3, size=nominal.shape)
        g = rng.normal(size=nominal.shape)
        took = timed(lambda: separate(e, g, nominal, spin), 2000 if imus == 1 else 5) / imus
        print(f"numpy {np.__version__}: separation of one IMU, {imus} at once      {1e6 * took:10.2f} us")
    print(f"numpy {np.__version__}: fit of {len(a)} dwells, three gyros         {1e6 * timed(fit, 200):10.2f} us")
    print(f"numpy {np.__version__}: least squares of a diagnosis         {1e3 * timed(diagnose, 1):10.2f} ms")


if __name__ == "__main__":
    main()
