"""Rand error of a labelling against people's, averaged: rand_error.py LABELS.seg FOLDER ID_category."""
import glob
import os
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


def people(name, folder):
    """Labellings by people of the mesh ID_category."""
    number = name.split("_")[0].lstrip("0")
    return [read(path) for path in sorted(glob.glob(os.path.join(folder, f"{number}_*.seg")))]


if __name__ == "__main__":
    own, given = read(sys.argv[1]), people(sys.argv[3], sys.argv[2])
    print(f"{sum(error(own, p) for p in given) / len(given):.4f}" if given else "nan")
