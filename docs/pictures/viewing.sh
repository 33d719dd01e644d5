#!/usr/bin/env bash
# Makes docs/pictures/view.png, view-dark.png and gtkwave.png: the page in the real Chromium, the save file in the real
# GTKWave. Needs chromium, gtkwave, xvfb, imagemagick and x11-utils (Debian's names).
set -euo pipefail
cd "$(dirname "$0")/../.."
discreta=${DISCRETA:-cargo run --release --quiet --}
folder=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null || true; rm -rf "$folder"' EXIT

shot() { # page address picture
    chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking --hide-scrollbars \
        --force-device-scale-factor=1 --user-data-dir="$folder/profile" --window-size=1280,860 --virtual-time-budget=3000 \
        --screenshot="$folder/shot.png" "file://$1$2" >/dev/null 2>&1
    convert "$folder/shot.png" -strip +dither -colors 200 "$3"
}
$discreta view circuits/evaluation/line.json -s dx=9 -s dy=5 -o "$folder/line.html"
shot "$folder/line.html" '#t=110&net=f&theme=light' docs/pictures/view.png
$discreta view circuits/quadrant/circle.json -o "$folder/circle.html"
shot "$folder/circle.html" '#t=150&net=f&theme=dark' docs/pictures/view-dark.png

$discreta run circuits/evaluation/line.json -s dx=9 -s dy=5 -o "$folder/line.vcd" --save
export DISPLAY=:94
Xvfb $DISPLAY -screen 0 1280x800x24 >/dev/null 2>&1 &
sleep 1
(cd "$folder" && exec gtkwave --rcvar 'splash_disable on' line.gtkw >/dev/null 2>&1) &
for _ in $(seq 60); do
    xwininfo -root -tree | grep -q 'GTKWave - ' && break
    sleep 0.5
done
sleep 3
import -window root "$folder/whole.png"
# without the frame of the window, which has no manager here
convert "$folder/whole.png" -trim +repage -strip docs/pictures/gtkwave.png
