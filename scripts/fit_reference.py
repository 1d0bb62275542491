#!/usr/bin/env python3
"""Fits model (6) to a campaign with scipy, as an independent check of `gyrowatch calibrate`.

    python3 scripts/fit_reference.py tests/data/practice/campaign-00.json

needs numpy and scipy (the figures in tests/calibration.rs: numpy 2.4.6, scipy 1.17.1). Weighted least squares with the gauge
P_x + P_y + P_z = 0 as a Lagrange condition (Karush-Kuhn-Tucker system, scipy.linalg.lstsq), covariance from the same
system's inverse, drift by rotating the nominal triad with scipy's Rotation, its standard deviations by central
differences. Nothing here follows the program's own route (QR, singular values, reduced columns).
"""

import json
import sys

import numpy as np
from scipy.linalg import inv, lstsq
from scipy.spatial.transform import Rotation

NOMINAL = {
    "G1": ([1 / 3**0.5, -1 / 6**0.5, 1 / 2**0.5], [0, 3**0.5 / 2, 0.5]),
    "G2": ([1 / 3**0.5, -1 / 6**0.5, -1 / 2**0.5], [0, 3**0.5 / 2, -0.5]),
    "G3": ([1 / 3**0.5, 2 / 6**0.5, 0], [0, 0, 1]),
}


def drift(e, g, nominal):
    """D_I, D_S, D_O in deg/(h g0): the nominal triad turned by the smallest rotation that takes I to E/|E|."""
    n, s = (np.array(v, float) for v in nominal)
    u = e / np.linalg.norm(e)
    axis = np.cross(n, u)
    angle = np.arctan2(np.linalg.norm(axis), n @ u)
    turn = Rotation.from_rotvec(axis / np.linalg.norm(axis) * angle)
    y = g / np.linalg.norm(e)
    return np.array([y @ u, y @ turn.apply(s), y @ turn.apply(np.cross(n, s))])


def main(path):
    campaign = json.load(open(path))
    dwells = campaign["dwells"]
    a = np.array([d["specific_force_g0"] for d in dwells])
    w = np.array([d["rate_arcsec_s"] for d in dwells])
    design = np.column_stack([np.ones(len(a)), a, a**2, w])
    names = ["D0", "G_x", "G_y", "G_z", "P_x", "P_y", "P_z", "E_x", "E_y", "E_z"]
    condition = np.array([0, 0, 0, 0, 1, 1, 1, 0, 0, 0.0])
    for j, gyro in enumerate(campaign["gyros"]):
        y = np.array([d["output_pulse_s"][j] for d in dwells])
        sem = np.array([d["output_sem_pulse_s"][j] for d in dwells])
        white, rhs = design / sem[:, None], y / sem
        size = np.linalg.norm(white, axis=0)
        system = np.zeros((11, 11))
        system[:10, :10] = (white / size).T @ (white / size)
        system[10, :10] = system[:10, 10] = condition / size
        solution = lstsq(system, np.append((white / size).T @ rhs, 0.0))[0][:10] / size
        covariance = inv(system)[:10, :10] / np.outer(size, size)
        residual = rhs - white @ solution
        print(f"// {gyro['slot']}: chi2 {residual @ residual:.6f} of {len(y) - 9}")
        for name, value, variance in zip(names, solution, np.diag(covariance)):
            print(f'("{name}", {value:.10e}, {variance**0.5:.6e}),')
        e, g = solution[7:], solution[1:4]
        nominal = NOMINAL[gyro["slot"]]
        jacobian = np.zeros((3, 6))
        eg = np.concatenate([e, g])
        for i in range(6):
            step = np.zeros(6)
            step[i] = 1e-5
            up, down = eg + step, eg - step
            jacobian[:, i] = (drift(up[:3], up[3:], nominal) - drift(down[:3], down[3:], nominal)) / 2e-5
        order = [7, 8, 9, 1, 2, 3]
        spread = np.sqrt(np.diag(jacobian @ covariance[np.ix_(order, order)] @ jacobian.T))
        for name, value, sd in zip(["D_I", "D_S", "D_O"], drift(e, g, nominal), spread):
            print(f'("{name}", {value:.10e}, {sd:.6e}),')


if __name__ == "__main__":
    main(*sys.argv[1:])
