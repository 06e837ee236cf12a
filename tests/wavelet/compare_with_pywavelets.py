"""Coefficients against PyWavelets (mode periodization), an independent code.

PyWavelets' coefficient k of a level is ours of the signal moved by  1 - L/2  input samples (L taps):
    c_pywt[k] = sum_n h[n] x[2k + n + 1 - L/2],
so haar agrees as it stands, db2 (daubechies-4) is one input sample later, coif1 (coiflet-6) two, at each level.
The detail filters agree in sign: g[n] = (-1)^n h[L-1-n] is PyWavelets' time-reversed dec_hi.

    compare_with_pywavelets.py DWT_DUMP        exit 0 equal, 1 different, 77 no PyWavelets (ctest: skipped)
"""
import subprocess
import sys

try:
    import numpy
    import pywt
except ImportError as missing:
    print(f"SKIPPED: {missing}; install python3-pywt to compare with PyWavelets", file=sys.stderr)
    sys.exit(77)

TOLERANCE = 1e-12  # relative to the largest coefficient; both codes work in double
LEVELS = 3
LETTERS = {"a": 0, "d": 1}


def one_level(dump, name, array):
    """Our subbands by orientation (bit 0: wavelet along x); arrays are indexed z, y, x."""
    nz, ny, nx = array.shape
    raw = subprocess.run([dump, name, str(nx), str(ny), str(nz)], input=array.tobytes(), stdout=subprocess.PIPE,
                         check=True).stdout
    shape = (8, nz // 2, ny // 2, nx // 2)
    return numpy.frombuffer(raw).reshape(shape)


def main(dump):
    rng = numpy.random.default_rng(20)
    worst = 0.0
    for name, peer in (("haar", "haar"), ("daubechies-4", "db2"), ("coiflet-6", "coif1")):
        shift = 1 - pywt.Wavelet(peer).dec_len // 2
        for shape in ((16, 24, 40), (8, 8, 8), (32, 8, 56)):
            theirs = rng.standard_normal(shape)
            for level in range(1, LEVELS + 1):
                # Our signal of this level is theirs moved: roll by -shift gives x[m + shift] at m.
                bands = one_level(dump, name, numpy.ascontiguousarray(numpy.roll(theirs, (-shift,) * 3, (0, 1, 2))))
                peer_bands = pywt.dwtn(theirs, peer, mode="periodization")
                scale = max(abs(band).max() for band in peer_bands.values())
                for key, band in peer_bands.items():
                    z, y, x = (LETTERS[c] for c in key)
                    difference = abs(bands[x + 2 * y + 4 * z] - band).max() / scale
                    worst = max(worst, difference)
                    if difference > TOLERANCE:
                        print(f"{name} level {level} subband {key}: differs by {difference:.2e}")
                        return 1
                theirs = peer_bands["aaa"]
    print(f"equal to {worst:.1e} of the largest coefficient")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
