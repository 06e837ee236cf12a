"""The order at which errors fall, and what is said of it."""

import math

ALLOWED = 0.2  # below theory

# What a kind of row refines: the tool, the label of its values, what of a value errors are a power of, and whether finer is
# smaller. Of widths errors are exponential: their order is decades a tap.
SAMPLES = ("samples an edge", lambda n: 1 / (n - 1), False)
STEP = ("step, voxels", lambda h: h, True)
KINDS = {
    "step": ("vol-raycast, steps", *STEP),
    "step-plain": ("vol-raycast --algorithm plain, steps", *STEP),
    "split": ("vol-raycast, split, by Gauss nodes", *SAMPLES),
    "grid": ("vol-raycast, X-ray of grids", *SAMPLES),
    "wavelet-grid": ("wavelet-raycast, grids", *SAMPLES),
    "wavelet-levels": ("wavelet-raycast, levels", "finest levels left out", lambda m: 2.0 ** m, True),
    "linearised": ("wavelet-raycast --linearised", "depth", lambda d: 2.0 ** -d, False),
    "width": ("fvr-slice, es:N, by padding", "width N", lambda n: 10.0 ** -n, False),
    "padding": ("fvr-slice, paddings", "padding", lambda p: 1 / p, False),
    "mesh-area": ("isosurf-mc, area", *SAMPLES),
    "mesh-volume": ("isosurf-mc, volume", *SAMPLES),
    "surface": ("isosurf-ray, depth", *SAMPLES),
    "image": ("vol-raycast --image-step", "pixels between rays", lambda s: s, True),
}


def lengths(row):
    """h of every value: errors are C h^order."""
    return [KINDS[row["kind"]][2](value) for value in row["over"]]


def slope(row):
    """Of log error over log h, by least squares over the finest `asymptotic` values."""
    n = row["asymptotic"]
    x = [math.log10(h) for h in lengths(row)[-n:]]
    y = [math.log10(error) for error in row["errors"][-n:]]
    middle = sum(x) / n
    return sum((a - middle) * b for a, b in zip(x, y)) / sum((a - middle) ** 2 for a in x)


def verdict(row):
    if slope(row) >= row["order"] - ALLOWED:
        return "kept"
    return "explained" if row.get("reason") else "BELOW"
