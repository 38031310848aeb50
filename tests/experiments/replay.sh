#!/bin/bash
# replay.sh PROGRAM SCENE FOLDER: a run repeats to the byte, and tracker and scissors need no truth.
set -eu
program=$1 scene=$2 folder=$3
rm -rf "$folder"
mkdir -p "$folder"
fail() { echo "$1"; exit 1; }
run() { "$program" run "$scene" -o "$folder/$1" --no-video --quiet --set duration_s=2.4 --set cut.at_s=0.3 "${@:2}" || [ $? = 1 ]; }

run first --record
run second --record --threads 2
"$program" check "$folder/first" "$folder/second" || fail "two runs differ"

rm -r "$folder/second/truth"
"$program" replay "$folder/second" --inputs || fail "other commands without the truth"
grep -q "^2.3" "$folder/first/inputs/commands.csv" || fail "the recording stops early"
cut -d, -f2- "$folder/first/inputs/commands.csv" | sort -u | wc -l | grep -qE "[0-9]{4}" || fail "the scissors were never commanded"

# Readings of the first arm that are off by a tenth of a millimetre are another run.
awk -F, -v OFS=, '$2 == 1 { $6 += 1e-4 } 1' "$folder/first/inputs/readings.csv" > "$folder/readings.csv"
mv "$folder/readings.csv" "$folder/second/inputs/readings.csv"
status=0; "$program" replay "$folder/second" --inputs > "$folder/out" || status=$?
[ $status = 1 ] || fail "commands don't depend on what was measured: $status"

"$program" replay "$folder/first" --quiet || fail "the replayed run differs"
status=0; "$program" replay "$folder" 2> "$folder/out" || status=$?
[ $status = 2 ] && [ "$(wc -l < "$folder/out")" = 1 ] || fail "not refused: $status"
