//! Judging any UV map: distortion, seams, overlap, statistics.
