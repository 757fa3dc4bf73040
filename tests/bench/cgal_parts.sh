#!/bin/sh
# CGAL's segmentation of every mesh of a folder, with its defaults: cgal_parts.sh FOLDER > TABLE
# Lines `mesh seconds error` for parts_bench. Needs g++, libcgal-dev and Python 3.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
folder=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
g++ -O3 -march=native -DNDEBUG "$here/cgal_parts.cpp" -o "$work/cgal_parts" -lgmp -lmpfr
for mesh in "$folder"/*.obj; do
    name=$(basename "$mesh" .obj)
    spent=$("$work/cgal_parts" "$mesh" "$work/out.seg")
    echo "$name $spent $(python3 "$here/rand_error.py" "$work/out.seg" "$folder/labels" "$name")"
done
