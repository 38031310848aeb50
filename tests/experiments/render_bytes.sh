#!/usr/bin/env bash
# render_bytes.sh PROGRAM SCENE WORK: the picture and its layers are the same bytes whatever llvmpipe's threads.
set -euo pipefail
program=$1 scene=$2 work=$3
rm -rf "$work" && mkdir -p "$work"
for threads in 0 1 2; do
    mkdir "$work/$threads"
    LP_NUM_THREADS=$threads "$program" render "$scene" --layers --quiet -o "$work/$threads/still.png"
    (cd "$work/$threads" && sha256sum *.png) >"$work/$threads.sums"
done
cat "$work/0.sums"
[ "$(wc -l <"$work/0.sums")" -eq 4 ]
cmp "$work/0.sums" "$work/1.sums"
cmp "$work/0.sums" "$work/2.sums"
