"""Rand error of a labelling against people's, averaged: rand_error.py LABELS.seg FOLDER ID_category."""
import glob
import sys
from collections import Counter


def pairs(counts):
    return sum(n * (n - 1) // 2 for n in counts.values())


def error(a, b):
    n = len(a)
    return (pairs(Counter(a)) + pairs(Counter(b)) - 2 * pairs(Counter(zip(a, b)))) / (n * (n - 1) / 2)


def read(path):
    with open(path) as file:
        return file.read().split()


own = read(sys.argv[1])
number = sys.argv[3].split("_")[0].lstrip("0")
people = [read(path) for path in sorted(glob.glob(f"{sys.argv[2]}/{number}_*.seg"))]
print(f"{sum(error(own, p) for p in people) / len(people):.4f}" if people else "nan")
