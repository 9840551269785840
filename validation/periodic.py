#!/usr/bin/env python3
"""Mean, amplitude and frequency of the quantities of a periodic run, by its harmonics.

usage: validation/periodic.py DIR...        last 1.1 s, 6 harmonics: made for fsi3

A polynomial through three samples, as in summary.json, needs short steps. Here the frequency and the first harmonics
of the leading quantity uy_A are fitted to all steps of the last periods; mean and amplitude are those of the fitted
function, (max + min)/2 and (max - min)/2. `fit` is the root mean square of what the fit leaves of the lift.
"""
import csv, os, sys
import numpy

SPAN, HARMONICS, LEADING = 1.1, 6, "uy_A"
UNITS = {"drag": 1, "lift": 1, "ux_A": 1e3, "uy_A": 1e3}


def design(times, frequency):
    phases = 2 * numpy.pi * frequency * times
    waves = [wave(n * phases) for n in range(1, HARMONICS + 1) for wave in (numpy.cos, numpy.sin)]
    return numpy.stack([numpy.ones_like(times), *waves], 1)


def fitted(matrix, values):
    coefficients = numpy.linalg.lstsq(matrix, values, rcond=None)[0]
    return coefficients, numpy.linalg.norm(matrix @ coefficients - values)


def frequency_of(times, values, guess=5.45):
    for width, count in ((0.15, 61), (0.006, 61), (0.0003, 31)):
        candidates = numpy.linspace(guess - width, guess + width, count)
        guess = min(candidates, key=lambda f: fitted(design(times, f), values)[1])
    return guess


def row(directory):
    with open(os.path.join(directory, "history.csv")) as file:
        rows = list(csv.DictReader(file))
    column = lambda name: numpy.array([float(row[name]) for row in rows])
    end = column("time")[-1]
    chosen = column("time") > end - SPAN
    frequency = frequency_of(column("time")[chosen] - end, column(LEADING)[chosen])
    period, words = numpy.linspace(0, 1 / frequency, 2000), []
    for name, unit in UNITS.items():
        at = column("force_time" if name in ("drag", "lift") else "time")[chosen] - end
        coefficients, left = fitted(design(at, frequency), column(name)[chosen])
        values = design(period, frequency) @ coefficients * unit
        middle, size = (values.max() + values.min()) / 2, (values.max() - values.min()) / 2
        words.append(f"{name} {middle:.3f} ± {size:.3f}")
        if name == "lift":
            rest = left / chosen.sum() ** 0.5
    newton = sum(int(row["newton_steps"]) for row in rows)
    return f"{', '.join(words)}, {frequency:.4f} Hz, {newton / len(rows):.2f} iterations a step, fit {rest:.1e}"


for directory in sys.argv[1:]:
    print(f"{directory}: {row(directory)}")
