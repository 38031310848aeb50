#!/usr/bin/env bash
# report_page.sh PROGRAM SCENE WORK: runs a short episode, opens its report.html in a headless browser, moves the
# slider to the end, and fails when time, pictures or the view in space do not follow, or the console has an error.
set -euo pipefail
program=$1 scene=$2 work=$3
browser=$(command -v chromium) || { echo "no chromium: packages/test.txt lists it"; exit 1; }
rm -rf "$work" && mkdir -p "$work"
"$program" run "$scene" -o "$work/run" --no-video --quiet --set duration_s=0.5 >/dev/null || [ $? -eq 1 ]

probe='<script>
const slider = document.getElementById("time"), before = document.getElementById("left").src;
slider.value = slider.max;
slider.dispatchEvent(new Event("input"));
const picture = document.getElementById("left");
document.title = ["probe", document.getElementById("now").textContent.split(",")[0], picture.src !== before,
  picture.src.startsWith("data:image/jpeg"), document.querySelectorAll("#space canvas").length,
  document.querySelectorAll("#error canvas").length > 0, document.getElementById("verdict").textContent].join("|");
</script>'
{ cat "$work/run/report.html"; echo "$probe"; } >"$work/probed.html"
if grep -oE '(src|href)="https?://[^"]*"' "$work/run/report.html"; then echo "the page asks the network"; exit 1; fi
timeout -k 5 100 "$browser" --headless --no-sandbox --user-data-dir="$work/browser" --use-angle=swiftshader \
    --enable-unsafe-swiftshader --virtual-time-budget=5000 --enable-logging=stderr --dump-dom \
    "file://$work/probed.html" >"$work/dom.html" 2>"$work/browser.log"
grep -aE 'CONSOLE.*(Uncaught|Error|error)' "$work/browser.log" && exit 1
title=$(grep -ao '<title>[^<]*' "$work/dom.html" | head -n 1)
echo "$title"
[ "$title" = "<title>probe|0.47 s|true|true|1|true|aborted" ]
