#!/usr/bin/env bash
# Makes docs/pictures/line.png: the waveform of the README as the real GTKWave shows it.
# Needs gtkwave, xvfb, imagemagick and x11-utils (Debian's names).
set -euo pipefail
cd "$(dirname "$0")/../.."
folder=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null || true; rm -rf "$folder"' EXIT
${DISCRETA:-cargo run --release --quiet --} run circuits/evaluation/line.json -s dx=5 -s dy=3 -o "$folder/line.vcd"
export DISPLAY=:93
Xvfb $DISPLAY -screen 0 1200x400x24 >/dev/null 2>&1 &
sleep 1
save=$PWD/docs/pictures/line.gtkw
(cd "$folder" && exec gtkwave --rcvar 'hide_sst on' --rcvar 'splash_disable on' line.vcd "$save" >/dev/null 2>&1) &
for _ in $(seq 60); do
    xwininfo -root -tree | grep -q 'GTKWave - ' && break
    sleep 0.5
done
sleep 3
import -window root "$folder/whole.png"
# without the frame of the window, which has no manager here
convert "$folder/whole.png" -trim +repage -strip docs/pictures/line.png
