"""Interleaved timing: every contender once a round, in an order that rotates, so that what disturbs the machine disturbs
all alike; and the medians with their intervals."""

import math
import statistics
import sys


def say(text):
    """A line of progress: pipelines/reproduce shows what begins so."""
    print(f"progress: {text}", file=sys.stderr, flush=True)


def interleaved(contenders, rounds, before=lambda number: None):
    """{name: seconds of each round} of {name: function that returns the seconds of one run}, after one untimed round;
    `before` is told the number of each round, -1 that of the untimed one."""
    names = list(contenders)
    times = {name: [] for name in names}
    for number in range(-1, rounds):
        before(number)
        shift = number % len(names) if names else 0
        for name in names[shift:] + names[:shift]:
            seconds = contenders[name]()
            if number >= 0:
                times[name].append(seconds)
    return times


def interval(values):
    """(median, low, high): the 95 % interval of the median by order statistics; of 9 values the second and the eighth."""
    ordered = sorted(values)
    n = len(ordered)
    if n < 6:  # no 95 % interval
        return statistics.median(ordered), statistics.median(ordered), statistics.median(ordered)
    outside, cut = 0.5 ** n, 0  # P(fewer than cut + 1 of n lie below the median)
    while cut + 1 < n / 2 and outside + math.comb(n, cut + 1) * 0.5 ** n <= 0.025:
        cut += 1
        outside += math.comb(n, cut) * 0.5 ** n
    return statistics.median(ordered), ordered[cut], ordered[n - 1 - cut]


def ratio(slow, fast):
    """(median, low, high) of how many times as fast `fast` is, round by round."""
    return interval([a / b for a, b in zip(slow, fast)])


def shown(found):
    median, low, high = found
    if low == high:
        return f"{median:.2f}"
    return f"{median:.2f} ({low:.2f} to {high:.2f})"
