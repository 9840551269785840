#!/usr/bin/env python3
"""Mean, amplitude and frequency of the quantities of a periodic run, by its harmonics.

usage: validation/periodic.py DIR...        last six periods, up to sixteen harmonics

A polynomial through three samples, as in summary.json, needs short steps. Here the frequency and the harmonics of the
leading quantity (uy_A, or lift without a body) are fitted to all steps of the last periods; mean and amplitude are
those of the fitted function, (max + min)/2 and (max - min)/2. `fit` is the root mean square of what the fit leaves of
the lift.
"""
import csv, json, os, sys
import numpy

PERIODS, HARMONICS = 6, 16
UNITS = {"drag": 1, "lift": 1, "ux_A": 1e3, "uy_A": 1e3}


def design(times, frequency, harmonics):
    phases = 2 * numpy.pi * frequency * times
    waves = [wave(n * phases) for n in range(1, harmonics + 1) for wave in (numpy.cos, numpy.sin)]
    return numpy.stack([numpy.ones_like(times), *waves], 1)


def fitted(matrix, values):
    coefficients = numpy.linalg.lstsq(matrix, values, rcond=None)[0]
    return coefficients, numpy.linalg.norm(matrix @ coefficients - values)


def frequency_of(times, values, guess, harmonics):
    for width, count in ((0.03, 61), (0.0012, 61), (0.00005, 31)):
        candidates = numpy.linspace(guess * (1 - width), guess * (1 + width), count)
        guess = min(candidates, key=lambda f: fitted(design(times, f, harmonics), values)[1])
    return guess


def guess_of(times, values):
    """From the last two times at which the values grow past their mean."""
    middle = (values.max() + values.min()) / 2
    up = numpy.nonzero((values[:-1] < middle) & (values[1:] >= middle))[0]
    crossings = times[up] + (middle - values[up]) / (values[up + 1] - values[up]) * (times[up + 1] - times[up])
    return 1 / (crossings[-1] - crossings[-2])


def periodic(directory, periods=PERIODS):
    """Frequency, and of each quantity its mean, amplitude, fit and values over one period.

    The period has 2000 parts; it begins where the leading quantity grows past its mean.
    """
    with open(os.path.join(directory, "history.csv")) as file:
        rows = list(csv.DictReader(file))
    column = lambda name: numpy.array([float(row[name]) for row in rows])
    names = [name for name in UNITS if name in rows[0]]
    leading = "uy_A" if "uy_A" in names else "lift"
    time = lambda name: column("force_time" if name in ("drag", "lift") else "time")
    end = column("time")[-1]
    recent = column("time") > end - 2  # two seconds have two periods of all cases
    guess = guess_of(column("time")[recent], column(leading)[recent])
    chosen = column("time") > end - periods / guess
    harmonics = min(HARMONICS, int(chosen.sum() / periods / 2.5))
    frequency = frequency_of(time(leading)[chosen] - end, column(leading)[chosen], guess, harmonics)
    result = {"frequency": frequency, "steps": len(rows), "quantities": {}}
    phases = numpy.linspace(-1 / frequency, 0, 2001)
    found = {}
    for name in names:
        coefficients, left = fitted(design(time(name)[chosen] - end, frequency, harmonics), column(name)[chosen])
        found[name] = design(phases, frequency, harmonics) @ coefficients * UNITS[name]
        middle, size = (found[name].max() + found[name].min()) / 2, (found[name].max() - found[name].min()) / 2
        fit = left / chosen.sum() ** 0.5 * UNITS[name]
        result["quantities"][name] = {"mean": middle, "amplitude": size, "fit": fit}
    middle = result["quantities"][leading]["mean"]
    first = next(i for i in range(2000) if found[leading][i] < middle <= found[leading][i + 1])
    result["values"] = {name: numpy.roll(values[:2000], -first) for name, values in found.items()}
    result["newton"] = sum(int(row["newton_steps"]) for row in rows) / len(rows)
    with open(os.path.join(directory, "summary.json")) as file:
        result["summary"] = json.load(file)
    return result


def line(directory):
    found = periodic(directory)
    words = [f"{name} {q['mean']:.3f} ± {q['amplitude']:.3f}" for name, q in found["quantities"].items()]
    fit = found["quantities"]["lift"]["fit"]
    return f"{', '.join(words)}, {found['frequency']:.4f} Hz, {found['newton']:.2f} iterations a step, fit {fit:.1e}"


if __name__ == "__main__":
    for directory in sys.argv[1:]:
        print(f"{directory}: {line(directory)}")
