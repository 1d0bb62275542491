#!/usr/bin/env python3
"""A second, independent maker of blind campaigns for `gyrowatch blindcheck --campaigns DIR --key DIR/key.json`.

It shares nothing with the program's own simulator: other code, other language, other random numbers, and another
way round. Here an effect is the written form of the catalogue (a column built from what the station commands),
there it is physics; here angles are small, there they are finite; here noise is given dwell by dwell in pulse/s.
A diagnosis whose figures hold on both does not owe them to one simulator.

    python3 scripts/blind_generator.py --out DIR --seed 7 --count 200
    python3 scripts/blind_generator.py --out DIR --seed 7 --count 200 --hard
    python3 scripts/blind_generator.py --out DIR --seed 7 --count 100 --pairs [--kind stepped]

With --hard the noise is not what standard errors say: they are wrong by a factor of their own for each gyro, or absent,
or the noise has heavy tails, and the programme is one that no table of positions lists.

With --pairs it makes two campaigns of each IMU: the same gyros, the same effects with the same coefficients, another order
of dwells, another course of temperature and other noise; the second is as warm as the first, or 3 K off. In some the
coefficients have tripled. --length makes chains, the last of which differs so. --kind makes all pairs alike; D_I of a gyro has `stepped` by 0.01 deg/(h g0), or it is `reseated`
60 arcsec off, without any effect.
"""

import argparse
import json
import pathlib

import numpy as np

EARTH = 15.041067
SLOTS = ["G1", "G2", "G3"]
SKEWED_I = np.array([[3**-0.5, -(6**-0.5), 2**-0.5], [3**-0.5, -(6**-0.5), -(2**-0.5)], [3**-0.5, (2 / 3) ** 0.5, 0]])
SKEWED_S = np.array([[0, 3**0.5 / 2, 0.5], [0, 3**0.5 / 2, -0.5], [0, 0, 1.0]])
ORTHOGONAL_I, ORTHOGONAL_S = np.eye(3), np.roll(np.eye(3), 1, axis=1)

# Every id that a campaign with rates, temperature and attitudes can show; those in OFF_AXIS need tilted positions.
PLAIN = """temperature_bias temperature_g temperature_scale warmup time_ramp bias_step outlier_dwell periodic hysteresis
scale_asymmetry scale_quadratic scale_cubic anisoinertia g_rate_coupling levelling azimuth magnetic""".split()
OFF_AXIS = ["cross_compliance", "cubic_g"]
COMMON = ["levelling", "azimuth"]
UNSEEN = ["cross_compliance", "cubic_g", "output_axis_g"]
OUTSIDE = """harmonics coloured square_of_temperature temperature_by_rate sawtooth wandering_bias several_outliers
scale_by_time chirp bump dead_band""".split()
DESIGNS = ["24", "60"]
HARD_DESIGNS = ["24", "60", "sphere", "one_sided"]


def axis_rotation(axis, angle):
    """Right-handed rotation of a vector about a unit axis (Rodrigues)."""
    x, y, z = axis
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def quaternion(c):
    """[w, x, y, z] of a rotation matrix, from the eigenvector of Bar-Itzhack's symmetric matrix."""
    m = np.array([
        [c[0, 0] - c[1, 1] - c[2, 2], c[1, 0] + c[0, 1], c[2, 0] + c[0, 2], c[2, 1] - c[1, 2]],
        [c[1, 0] + c[0, 1], c[1, 1] - c[0, 0] - c[2, 2], c[2, 1] + c[1, 2], c[0, 2] - c[2, 0]],
        [c[2, 0] + c[0, 2], c[2, 1] + c[1, 2], c[2, 2] - c[0, 0] - c[1, 1], c[1, 0] - c[0, 1]],
        [c[2, 1] - c[1, 2], c[0, 2] - c[2, 0], c[1, 0] - c[0, 1], c[0, 0] + c[1, 1] + c[2, 2]],
    ])
    x, y, z, w = np.linalg.eigh(m)[1][:, -1]
    return np.array([w, x, y, z])


def onto_up(up):
    """A rotation nav to body that brings nav's up onto body direction `up`."""
    up = np.asarray(up, float) / np.linalg.norm(up)
    axis = np.cross([0, 0, 1.0], up)
    if np.linalg.norm(axis) < 1e-9:
        return np.eye(3) if up[2] > 0 else axis_rotation([1.0, 0, 0], np.pi)
    return axis_rotation(axis / np.linalg.norm(axis), np.arccos(up[2]))


def programme(rng, design, style):
    """Attitudes, table rates (arcsec/s), start and duration of each dwell."""
    faces = [s * np.eye(3)[k] for k in range(3) for s in (1, -1)]
    statics = [onto_up(f) @ axis_rotation([0, 0, 1.0], h * np.pi / 2) for f in faces for h in range(4)]
    if design == "60":
        for p, q in ((0, 1), (1, 2), (2, 0)):
            for degrees in range(0, 360, 15):
                if degrees % 90 in (30, 45, 60):
                    up = np.zeros(3)
                    up[p], up[q] = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
                    statics.append(onto_up(up))
    if design == "sphere":
        # A spiral of even density over the sphere, each direction with a heading of its own.
        height = 1 - 2 * (np.arange(48) + 0.5) / 48
        turns = np.pi * (1 + 5**0.5) * np.arange(48)
        across = np.sqrt(1 - height**2)
        ups = np.c_[across * np.cos(turns), across * np.sin(turns), height]
        statics = [onto_up(u) @ axis_rotation([0, 0, 1.0], rng.uniform(0, 2 * np.pi)) for u in ups]
    statics += [statics[k] for k in rng.choice(len(statics), style["repeats"], replace=False)]
    rates = [(onto_up(f), s * r) for f in faces for r in style["rates"] for s in (1, -1)]
    if design == "one_sided":
        # Each axis up only, and the two senses at rates of their own.
        rates = [(onto_up(f), s * r * (1.0 if s > 0 else 0.8)) for f in faces[::2] for r in style["rates"] for s in (1, -1)]
    everything = [(c, 0.0) for c in statics] + rates
    split = len(statics)
    if style["order"] == "random":
        index = list(rng.permutation(split)) + list(split + rng.permutation(len(rates)))
        everything = [everything[k] for k in index]
    elif style["order"] == "mixed":
        everything = [everything[k] for k in rng.permutation(len(everything))]
    step = style["dwell"] + style["settle"]
    start = np.arange(len(everything)) * step
    return [c for c, _ in everything], np.array([r for _, r in everything]), start


def smooth(rng, n, length):
    """Zero-mean smooth noise of unit variance: white noise under a Gaussian window."""
    window = np.exp(-0.5 * (np.arange(-4 * length, 4 * length + 1) / length) ** 2)
    x = np.convolve(rng.normal(size=n + 8 * length), window, "valid")
    return (x - x.mean()) / x.std()


def temperature(rng, n):
    kind = rng.choice(["wander", "wander", "ramp", "cycle"])
    s = np.linspace(-0.5, 0.5, n)
    if kind == "ramp":
        return 45 + rng.uniform(0.8, 2.5) * s * rng.choice([-1, 1]) + 0.08 * smooth(rng, n, 3)
    if kind == "cycle":
        return 45 + rng.uniform(0.4, 1.0) * np.sin(2 * np.pi * rng.uniform(1.2, 4) * s + rng.uniform(0, 6)) \
            + 0.05 * smooth(rng, n, 3)
    return 45 + rng.uniform(0.3, 0.9) * smooth(rng, n, int(rng.integers(4, 12)))


class Campaign:
    def __init__(self, rng, design, style):
        self.rng, self.style, self.design = rng, style, design
        self.count = style["gyros"]
        self.latitude = np.radians(style["latitude"])
        self.gravity = 0.9973 + 0.0053 * np.sin(self.latitude) ** 2
        attitudes, self.turn, self.start = programme(rng, design, style)
        n = self.n = len(attitudes)
        self.attitudes = attitudes
        north, up = EARTH * np.cos(self.latitude), EARTH * np.sin(self.latitude)
        self.static = self.turn == 0
        self.a = np.array([c[:, 2] * self.gravity for c in attitudes])
        self.w = np.array([c @ [0, 0 if r else north, up + r] for c, r in zip(attitudes, self.turn)])
        self.t = (self.start + style["dwell"] / 2) / 3600
        self.temperature = temperature(rng, n)
        nominal_i, nominal_s = (SKEWED_I, SKEWED_S) if style["geometry"] == "skewed" else (ORTHOGONAL_I, ORTHOGONAL_S)
        self.i, self.s = np.zeros((3, 3)), np.zeros((3, 3))
        for j in range(3):
            small = np.eye(3)
            for axis in np.eye(3):
                small = axis_rotation(axis, rng.normal(0, np.radians(0.08))) @ small
            self.i[j], self.s[j] = small @ nominal_i[j], small @ nominal_s[j]
        self.o = np.cross(self.i, self.s)
        self.k = rng.uniform(1.45, 1.49, 3)
        self.d_f, self.d_i, self.d_s = rng.normal(0, 2, 3), rng.normal(0, 5, 3), rng.normal(0, 7, 3)
        self.quality = np.array([rng.uniform(0.9, 1.1) for _ in range(3)])
        self.find_noise()
        self.reference_c = None

    def find_noise(self):
        floor = self.style["noise"]
        loud = np.hypot(floor, floor * np.abs(self.turn) / self.style["knee"])
        self.sd = self.quality[:, None] * loud
        n = self.n
        design_matrix = np.c_[np.ones(n), self.a, self.a**2, self.w]
        self.left_over = []
        for j in range(3):
            whitened = design_matrix / self.sd[j][:, None]
            u, s, _ = np.linalg.svd(whitened / np.linalg.norm(whitened, axis=0), full_matrices=False)
            basis = u[:, s > 1e-9 * s[0]]
            self.left_over.append(lambda y, basis=basis, sd=self.sd[j]: y / sd - basis @ (basis.T @ (y / sd)))

    def column(self, effect, j):
        """What effect adds to gyro j's drift at unit size, deg/h (scale effects times rate)."""
        rng, a, w, t = self.rng, self.a, self.w, self.t
        i, s, o = self.i[j], self.s[j], self.o[j]
        ai, as_, ao, wi, ws = a @ i, a @ s, a @ o, w @ i, w @ s
        warm = self.temperature - (self.temperature.mean() if self.reference_c is None else self.reference_c)
        n, shared = self.n, self.shared
        north = np.array([c[:, 1] if r == 0 else 0 * c[:, 1] for c, r in zip(self.attitudes, self.turn)])
        east = np.array([c[:, 0] if r == 0 else 0 * c[:, 0] for c, r in zip(self.attitudes, self.turn)])
        g = self.d_i[j] * i + self.d_s[j] * s
        unit = lambda k: (lambda v: v / np.linalg.norm(v))(rng.normal(size=k))
        rate_n, rate_u = EARTH * np.cos(self.latitude), EARTH * np.sin(self.latitude)
        up = a / self.gravity
        if effect == "levelling":
            east_tilt, north_tilt = shared["tilt"]
            # The table tilted about east by e and north by f: up leans, and Earth rate is resolved a little wrong.
            lean = -east_tilt * north + north_tilt * east
            turned = east_tilt * (rate_n * up - rate_u * north) + north_tilt * rate_u * east
            return turned @ i + self.gravity * lean @ g
        if effect == "azimuth":
            return rate_n * (-east @ i)
        forms = {
            "temperature_bias": lambda: warm,
            "temperature_g": lambda: warm * (a @ np.array([i, s]).T @ unit(2)),
            "temperature_scale": lambda: wi * warm,
            "warmup": lambda: np.exp(-t / shared["tau"]),
            "time_ramp": lambda: t,
            "bias_step": lambda: (np.arange(n) >= shared["step"]) * 1.0,
            "outlier_dwell": lambda: (np.arange(n) == shared["outlier"]) * 1.0,
            "periodic": lambda: np.sin(2 * np.pi * t / shared["period"] + shared["phase"]),
            "hysteresis": lambda: np.r_[0, ao[:-1]],
            "scale_asymmetry": lambda: np.abs(wi),
            "scale_quadratic": lambda: wi**2,
            "scale_cubic": lambda: wi**3,
            "anisoinertia": lambda: wi * ws,
            "g_rate_coupling": lambda: wi * ai,
            "magnetic": lambda: (north * 0.6 - up * 0.8) @ unit(3),
            "cross_compliance": lambda: np.c_[ai * as_, ai * ao, ao * as_] @ unit(3),
            "cubic_g": lambda: ai**3,
            "output_axis_g": lambda: ao,
            "harmonics": lambda: self.harmonics(),
            "coloured": lambda: smooth(rng, n, 2) + 0.3 * smooth(rng, n, 5),
            "square_of_temperature": lambda: warm**2,
            "temperature_by_rate": lambda: warm * np.abs(ws),
            "sawtooth": lambda: (t / shared["period_slow"] + shared["phase"]) % 1.0,
            "wandering_bias": lambda: np.cumsum(rng.normal(size=n)),
            "several_outliers": lambda: np.isin(np.arange(n), shared["outliers"]) * rng.choice([-1, 1], n) * rng.uniform(0.7, 1.3, n),
            "scale_by_time": lambda: wi * t,
            "chirp": lambda: np.sin(2 * np.pi * (1.0 + 2.5 * t / t[-1]) * t / t[-1] + shared["phase"]),
            "bump": lambda: np.exp(-0.5 * ((t - shared["centre"]) / shared["width"]) ** 2),
            "dead_band": lambda: np.sign(ws) * (np.abs(ws) > shared["band"] * np.abs(ws).max()),
        }
        return forms[effect]()

    def harmonics(self):
        """A random smooth function of the whole attitude, also of the heading."""
        c = np.array([np.r_[c[:, 2], c[:, 1] * (r == 0)] for c, r in zip(self.attitudes, self.turn)])
        x = c @ self.rng.normal(size=(6, 5))
        return np.tanh(x) @ self.rng.normal(size=5) + (x[:, 0] * x[:, 1]) * self.rng.normal()

    def draw_shared(self):
        """Particulars that all gyros of one campaign share: instants, periods, the table's tilt."""
        rng, n, span = self.rng, self.n, self.t[-1]
        angle = rng.uniform(0, 2 * np.pi)
        self.shared = {
            "tilt": (np.cos(angle), np.sin(angle)),
            "tau": span * rng.uniform(0.06, 0.3),
            "step": int(rng.integers(n // 5, n - n // 5)),
            "outlier": int(rng.integers(0, n)),
            "period": span / rng.uniform(1.5, n / 6),
            "period_slow": span / rng.uniform(2, 5),
            "phase": rng.uniform(0, 2 * np.pi),
            "outliers": rng.choice(n, int(rng.integers(3, 7)), replace=False),
            "centre": span * rng.uniform(0.3, 0.7),
            "width": span * rng.uniform(0.04, 0.1),
            "band": rng.uniform(0.2, 0.6),
        }

    def response(self, effect, d):
        """Responses in pulse/s of every gyro, sized to detectability d over all; and size, own d, gyros."""
        self.draw_shared()
        chosen = np.ones(self.count, bool)
        if effect not in COMMON:
            chosen = self.rng.random(self.count) < 0.6
            chosen[self.rng.integers(self.count)] = True
        columns = [self.k[j] * self.column(effect, j) * chosen[j] for j in range(self.count)]
        if effect not in COMMON:
            columns = [c * self.rng.choice([-1, 1]) for c in columns]
        own = np.array([np.linalg.norm(self.left_over[j](c)) for j, c in enumerate(columns)])
        seen = np.linalg.norm(own)
        size = 1.0 if d is None else d / seen
        hidden = d is None
        return [size * c for c in columns], size, own * size, [] if hidden else [SLOTS[j] for j in np.nonzero(own)[0]]

    def measured(self, responses):
        out = []
        for j in range(self.count):
            g = self.d_i[j] * self.i[j] + self.d_s[j] * self.s[j]
            ideal = self.k[j] * (self.w @ self.i[j] + self.d_f[j] + self.a @ g)
            out.append(ideal + sum(r[j] for r in responses) + self.sd[j] * self.noise())
        return np.array(out)

    def noise(self):
        """Unit variance: normal, or Student's t with 5 degrees of freedom."""
        if self.style["sem"] == "heavy_tails":
            return self.rng.standard_t(5, size=self.n) / (5 / 3) ** 0.5
        return self.rng.normal(size=self.n)

    def standard_errors(self):
        """As stated by the station, three gyros by dwells; none where it states none."""
        scatter = {"exact": 0.0, "noisy": 0.12, "wrong": 0.12, "heavy_tails": 0.05}.get(self.style["sem"])
        if scatter is None:
            return None
        stated = self.sd * np.clip(1 + scatter * self.rng.normal(size=self.sd.shape), 0.4, None)
        if self.style["sem"] == "wrong":
            stated *= np.exp(self.rng.normal(0, 0.2) + self.rng.normal(0, 0.1, (3, 1)))
        return stated

    def document(self, number, outputs):
        style, sem = self.style, self.standard_errors()
        dwells = []
        for k in range(self.n):
            dwell = {
                "phase": "static" if self.static[k] else "rate",
                "start_s": float(self.start[k]),
                "duration_s": float(style["dwell"]),
                "attitude": [round(x, 10) for x in quaternion(self.attitudes[k])],
                "specific_force_g0": [round(x, 9) for x in self.a[k]],
                "rate_arcsec_s": [round(x, 8) for x in self.w[k]],
                "temperature_c": round(float(self.temperature[k]), 3),
                "output_pulse_s": [round(outputs[j, k], 10) for j in range(self.count)],
            }
            if sem is not None:
                dwell["output_sem_pulse_s"] = [float(f"{sem[j, k]:.3g}") for j in range(self.count)]
            for column in style["missing"]:
                del dwell[column]
            dwells.append(dwell)
        return {
            "imu": f"IMU-{number:04d}", "station": "ST-B", "measured_at": "2026-04-01T06:00:00+08:00",
            "geometry": style["geometry"],
            "site": {"latitude_deg": round(np.degrees(self.latitude), 6), "gravity_g0": round(self.gravity, 9)},
            "gyros": [{"slot": SLOTS[j], "serial": f"B-{number:04d}-{j}"} for j in range(self.count)],
            "dwells": dwells,
        }


def style(rng, hard):
    return {
        "repeats": int(rng.choice([0, 4, 6, 12])),
        "rates": [360.0, 1800.0, 3600.0, 7200.0] if rng.random() < 0.7 else [900.0, 3600.0, 10800.0],
        "order": str(rng.choice(["random", "random", "mixed"])),
        "dwell": float(rng.choice([120, 180, 300])), "settle": float(rng.choice([30, 60])),
        "gyros": int(rng.choice([3, 3, 3, 3, 2, 1])),
        "latitude": float(rng.uniform(-60, 60)),
        "geometry": "skewed" if rng.random() < 0.8 else "orthogonal",
        "noise": float(rng.uniform(0.8e-3, 2.4e-3)), "knee": float(rng.uniform(4000, 12000)),
        "sem": str(rng.choice(["wrong", "wrong", "heavy_tails", "absent"] if hard else ["exact", "noisy", "noisy", "absent"])),
        "missing": [],
    }


def cases(rng, hard):
    """One campaign's case: kind, effects with their d (None: cannot be seen), design."""
    kind = rng.choice(["one", "faint", "clean", "pair", "outside", "unseen"], p=[0.4, 0.1, 0.2, 0.12, 0.12, 0.06])
    design = str(rng.choice(HARD_DESIGNS if hard else DESIGNS))
    names = PLAIN + (OFF_AXIS if design in ("60", "sphere") else [])
    if kind == "one":
        return [(str(rng.choice(names)), float(rng.choice([8, 12, 20, 30])))], design
    if kind == "faint":
        return [(str(rng.choice(names)), 5.0)], design
    if kind == "pair":
        first, second = rng.choice(names, 2, replace=False)
        return [(str(first), 12.0), (str(second), 12.0)], design
    if kind == "outside":
        return [(str(rng.choice(OUTSIDE)), float(rng.choice([15, 20, 30])))], design
    if kind == "unseen":
        return [(str(rng.choice(UNSEEN)), None)], "24"
    return [], design


def one(seed, number, hard):
    rng = np.random.default_rng([seed, number])
    effects, design = cases(rng, hard)
    campaign = Campaign(rng, design, style(rng, hard))
    drawn = [campaign.response(name, d) for name, d in effects]
    outputs = campaign.measured([columns for columns, *_ in drawn])
    together = [sum(columns[j] for columns, *_ in drawn) for j in range(campaign.count)] if drawn else []
    seen = float(np.linalg.norm([np.linalg.norm(campaign.left_over[j](y)) for j, y in enumerate(together)]))
    family = [name for name, _ in effects if name in OUTSIDE]
    entry = {
        "effects": ["outside the catalogue" if name in OUTSIDE else name for name, _ in effects],
        "sizes": [size for _, size, _, _ in drawn],
        "design": design, "sem": campaign.style["sem"], "seen": seen,
        "gyros": sorted({slot for *_, gyros in drawn for slot in gyros}),
        "truth": [{"D_I": campaign.d_i[j], "D_S": campaign.d_s[j], "K": campaign.k[j], "D_F": campaign.d_f[j],
                   "I": list(campaign.i[j]), "S": list(campaign.s[j])} for j in range(campaign.count)],
        "seen_by": [{SLOTS[j]: float(own[j]) for j in range(campaign.count)} for _, _, own, _ in drawn],
    }
    if family:
        entry["family"] = family[0]
    return campaign.document(number, outputs), entry


LASTING = """temperature_bias temperature_g temperature_scale hysteresis scale_asymmetry scale_quadratic anisoinertia
g_rate_coupling magnetic levelling azimuth warmup""".split()


class Same:
    """Draws the same directions for each campaign of a pair."""

    def __init__(self, seed):
        self.seed = seed

    def normal(self, size=None):
        return np.random.default_rng(self.seed).normal(size=size)


def changed(rng, first, second, kind):
    """One gyro of the second campaign has stepped in D_I by 0.01 deg/(h g0), or is seated 60 arcsec off."""
    j = int(rng.integers(first.count))
    if kind == "stepped":
        second.d_i = np.array(first.d_i, float)
        second.d_i[j] += 0.01 * rng.choice([-1, 1])
    if kind == "reseated":
        turn = axis_rotation(rng.normal(size=3), np.radians(60 / 3600))
        for axes in "iso":
            moved = [np.array(axis) for axis in getattr(first, axes)]
            moved[j] = turn @ moved[j]
            setattr(second, axes, moved)


def chain(seed, number, wanted=None, length=2):
    """Campaigns of one IMU, the last of which may differ, and what is true of them; `wanted`: the kind of all chains."""
    rng = np.random.default_rng([seed, number, 2])
    kind = str(rng.choice(["same", "warmer", "tripled", "clean"], p=[0.3, 0.4, 0.15, 0.15]))
    kind = wanted or kind
    design = str(rng.choice(DESIGNS))
    count = 1 if kind == "tripled" else int(rng.choice([1, 2])) if kind in ("same", "warmer") else 0
    effects = [str(name) for name in rng.choice(LASTING, count, replace=False)]
    given = style(rng, False)
    campaigns = [Campaign(rng, design, given) for _ in range(length)]
    first, last = campaigns[0], campaigns[-1]
    for campaign in campaigns[1:]:
        for name in "k i s o d_f d_i d_s quality".split():
            setattr(campaign, name, getattr(first, name))
        campaign.find_noise()
    if kind in ("warmer", "clean_warmer"):
        last.temperature += 3.0 * rng.choice([-1, 1])
    if kind in ("stepped", "reseated"):
        changed(rng, first, last, kind)
    first.draw_shared()
    for campaign in campaigns[1:]:
        campaign.shared = first.shared
    responses, key, moved = [[] for _ in campaigns], [], np.zeros((2, 3))
    for effect in effects:
        chosen = np.ones(first.count, bool)
        if effect not in COMMON:
            chosen = rng.random(first.count) < 0.7
            chosen[rng.integers(first.count)] = True
        direction = [int(x) for x in rng.integers(1 << 30, size=3)]
        columns = []
        for campaign in campaigns:
            kept = campaign.rng
            of_gyros = []
            for j in range(first.count):
                campaign.rng, campaign.reference_c = Same(direction[j]), 45.0
                of_gyros.append(campaign.k[j] * campaign.column(effect, j) * chosen[j])
            campaign.rng = kept
            columns.append(of_gyros)
        seen = np.linalg.norm([np.linalg.norm(first.left_over[j](c)) for j, c in enumerate(columns[0])])
        size = (20.0 if kind == "tripled" else float(rng.choice([12, 20, 40]))) / seen
        size *= rng.choice([-1, 1])
        for campaign, of_gyros, response in zip(campaigns, columns, responses):
            times = 3.0 if kind == "tripled" and campaign is last else 1.0
            response.append([times * size * c for c in of_gyros])
        if effect == "temperature_g":
            for j in range(first.count):
                d = Same(direction[j]).normal(size=2)
                moved[:, j] += size * chosen[j] * d / np.linalg.norm(d)
        key.append(effect)
    documents = []
    for quarter, (campaign, given) in enumerate(zip(campaigns, responses), 1):
        document = campaign.document(number, campaign.measured(given))
        document["measured_at"] = f"{2026 + quarter // 4}-{3 * (quarter % 4) + 1:02d}-01T06:00:00+08:00"
        documents.append(document)
    truth = {"kind": kind, "effects": key, "sem": first.style["sem"], "design": design,
             "D_I": list(first.d_i[:first.count]), "D_S": list(first.d_s[:first.count]),
             "per_kelvin": moved[:, :first.count].tolist(), "reference_c": 45.0}
    return documents, truth


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder to write campaigns and key.json into")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--hard", action="store_true", help="standard errors wrong or absent, heavy tails, other designs")
    parser.add_argument("--pairs", action="store_true", help="two campaigns of each IMU")
    parser.add_argument("--length", type=int, default=2, help="with --pairs: so many campaigns of each IMU, up to 8")
    parser.add_argument("--kind", choices="same warmer tripled clean clean_warmer stepped reseated".split(),
                        help="all pairs of this kind")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    key = {}
    for number in range(options.count if options.pairs else 0):
        documents, entry = chain(options.seed, number, options.kind, options.length)
        names = [f"pair-{number:04d}-{letter}.json" for letter in "abcdefgh"[:options.length]]
        for name, document in zip(names, documents):
            (options.out / name).write_text(json.dumps(document))
        key[names[0]] = {"between": names[1:-1], "next": names[-1], **entry}
    for number in range(0 if options.pairs else options.count):
        document, entry = one(options.seed, number, options.hard)
        name = f"blind-{number:04d}.json"
        (options.out / name).write_text(json.dumps(document))
        key[name] = entry
    (options.out / "key.json").write_text(json.dumps(key, indent=1))


if __name__ == "__main__":
    main()
