#!/usr/bin/env python3
"""Draws docs/figures/paper-experiment.svg: how the ranges of Table 5 fall out on simulated gyros.

    gyrowatch simulate --preset paper-experiment --csv | python3 scripts/paper_experiment_figure.py > docs/figures/paper-experiment.svg
"""

import csv
import math
import sys

WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 760, 360, 60, 50, 30, 20
LOW, HIGH, HEADLINE = 1e-5, 1.0, 1.301e-3
CURVES = [("rigid", "D_I", "#1b6ca8", ""), ("rigid", "D_S", "#1b6ca8", "6 4"),
          ("published", "D_I", "#c0392b", ""), ("published", "D_S", "#c0392b", "6 4")]


def x(value):
    share = math.log(max(value, LOW) / LOW) / math.log(HIGH / LOW)
    return LEFT + share * (WIDTH - LEFT - RIGHT)


def y(share):
    return HEIGHT - BOTTOM - share * (HEIGHT - BOTTOM - TOP)


def spread(row, method):
    results = [float(row[name]) for name in ("bench_before", method, "bench_after") if row[name]]
    return max(results) - min(results) if len(results) == 3 else math.inf


def curve(ranges):
    steps = [f"M{x(LOW):.1f},{y(0):.1f}"]
    for k, value in enumerate(sorted(ranges)):
        steps.append(f"H{x(min(value, HIGH)):.1f}V{y((k + 1) / len(ranges)):.1f}")
    return "".join(steps) + f"H{x(HIGH):.1f}"


def main():
    rows = list(csv.DictReader(sys.stdin))
    text = 'font-family="sans-serif" font-size="12" fill="#333"'
    print(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img">')
    print("<title>Share of cases with a range below a given value, by method and coefficient</title>")
    print(f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>')
    for power in range(-5, 1):
        at = x(10.0**power)
        print(f'<path d="M{at:.1f},{y(0):.1f}V{y(1):.1f}" stroke="#ddd"/>')
        print(f'<text x="{at:.1f}" y="{y(0) + 18:.1f}" text-anchor="middle" {text}>1e{power}</text>')
    for tenth in range(0, 11, 2):
        print(f'<path d="M{LEFT},{y(tenth / 10):.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>')
        print(f'<text x="{LEFT - 8}" y="{y(tenth / 10) + 4:.1f}" text-anchor="end" {text}>{tenth * 10} %</text>')
    print(f'<path d="M{x(HEADLINE):.1f},{y(0):.1f}V{y(1):.1f}" stroke="#333" stroke-dasharray="2 3"/>')
    print(f'<text x="{x(HEADLINE) + 4:.1f}" y="{TOP - 8}" {text}>Table 5: 1.301e-3</text>')
    for k, (method, coefficient, colour, dash) in enumerate(CURVES):
        ranges = [spread(row, method) for row in rows if row["coefficient"] == coefficient]
        style = f'stroke="{colour}" stroke-width="1.8" stroke-dasharray="{dash}" fill="none"'
        print(f'<path d="{curve(ranges)}" {style}/>')
        print(f'<path d="M{LEFT + 12},{TOP + 16 + 18 * k}h26" {style}/>')
        print(f'<text x="{LEFT + 44}" y="{TOP + 20 + 18 * k}" {text}>{method}, {coefficient}</text>')
    print(f'<text x="{(LEFT + WIDTH) / 2}" y="{HEIGHT - 10}" text-anchor="middle" {text}>'
          "range of bench before, IMU, bench after, deg/(h g0)</text>")
    print("</svg>")


if __name__ == "__main__":
    main()
