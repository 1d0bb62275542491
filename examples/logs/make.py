#!/usr/bin/env python3
"""Writes table.csv and programme.csv: a short raw log of three gyros on a table, and what the table was told.

gyrowatch dwells table.csv --map map.toml --programme programme.csv -o campaign.json
"""
import math
import random

AXES = {"+X": (1, 0, 0), "-X": (-1, 0, 0), "+Y": (0, 1, 0), "-Y": (0, -1, 0), "+Z": (0, 0, 1), "-Z": (0, 0, -1)}
EARTH, LATITUDE, GRAVITY = 15.041067, math.radians(34.25), 0.99905  # arcsec/s, rad, g0
E = [(0.8473, -0.6011, 1.0367), (0.8478, -0.6000, -1.0381), (0.8533, 1.2062, -0.0008)]  # pulse/arcsec
G = [(2.4210, 4.0554, 6.5179), (0.8634, 4.6419, -3.4081), (0.9901, 1.4495, -9.9775)]  # pulse/(s g0)
BIAS = [2.4, -1.1, 0.7]  # pulse/s
DWELL_S, SLEW_S, NOISE = 80, 10, 0.03


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def noise(of=random.Random(1)):
    return NOISE * (sum(of.random() for _ in range(12)) - 6.0)


def output(up, north, rate, seconds):
    """What the gyros count in a second: the Earth's horizontal rate goes round in the body while the table turns."""
    east, angle = cross(north, up), math.radians(rate * seconds)
    turned = [n * math.cos(angle) + e * math.sin(angle) for n, e in zip(north, east)]
    vertical = EARTH * math.sin(LATITUDE) + 3600.0 * rate
    turn = [EARTH * math.cos(LATITUDE) * t + vertical * u for t, u in zip(turned, up)]
    force = [GRAVITY * u for u in up]
    return [BIAS[k] + dot(G[k], force) + dot(E[k], turn) + noise() for k in range(3)]


positions = [(u, n, 0) for u in AXES for n in AXES if dot(AXES[u], AXES[n]) == 0]
positions += [(u, "+Y" if u[1] != "Y" else "+Z", rate) for u in AXES for rate in (10, -10)]
with open("table.csv", "w") as log, open("programme.csv", "w") as programme:
    log.write("time [s];gyro_1 [pulse];gyro_2 [pulse];gyro_3 [pulse];table [deg/s]\n")
    programme.write("up,north,rate_deg_s\n")
    time, before = 0, (0.0, 0.0, 0.0)
    for up, north, rate in positions:
        programme.write(f"{up},{north},{rate}\n")
        first = output(AXES[up], AXES[north], rate, 0.0)
        for second in range(SLEW_S + DWELL_S):
            share, told = (second + 0.5) / SLEW_S, 0
            if second < SLEW_S:
                swing = 5000.0 * math.sin(math.pi * share)
                counts = [b * (1 - share) + f * share + swing for b, f in zip(before, first)]
            else:
                told = rate
                counts = output(AXES[up], AXES[north], rate, second - SLEW_S + 0.5)
            log.write(f"{time};" + ";".join(f"{c:.3f}" for c in counts) + f";{told}\n")
            time += 1
        before = counts
