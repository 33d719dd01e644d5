#!/usr/bin/env bash
# docs/pictures/make.sh [FOLDER]: the pictures that are photographs, in docs/pictures or elsewhere: the page in the real
# Chromium, the save file in the real GTKWave. The drawings beside them are made by their tests (BLESS=1).
# Needs chromium, gtkwave, xvfb, xauth, imagemagick and x11-utils (Debian's names).
set -euo pipefail
into=$(realpath "${1:-$(dirname "$0")}")
cd "$(dirname "$0")/../.."
discreta=${DISCRETA:-cargo run --quiet --}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

page() { # address picture
    chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking --hide-scrollbars \
        --force-device-scale-factor=1 --user-data-dir="$folder/profile" --window-size=1280,860 --virtual-time-budget=3000 \
        --screenshot="$folder/shot.png" "file://$folder/$1" >/dev/null 2>&1
    convert "$folder/shot.png" -strip +dither -colors 200 "$into/$2"
}
$discreta view circuits/evaluation/line.json -s dx=9 -s dy=5 -o "$folder/line.html" >/dev/null
page 'line.html#t=110&net=f&theme=light' view.png
page 'line.html#t=110&net=f&theme=dark' view-dark.png
$discreta view circuits/quadrant/circle.json -o "$folder/circle.html" >/dev/null
page 'circle.html#t=150&net=f&theme=dark' arc-dark.png

$discreta run circuits/evaluation/line.json -s dx=9 -s dy=5 -o "$folder/line.vcd" --save >/dev/null
export folder
xvfb-run -a -s '-screen 0 1280x800x24' bash -c '
    (cd "$folder" && exec gtkwave --rcvar "splash_disable on" line.gtkw >/dev/null 2>&1) &
    for _ in $(seq 120); do
        xwininfo -root -tree | grep -q "GTKWave - " && break
        sleep 0.5
    done
    sleep 3
    import -window root "$folder/whole.png"
    kill $!'
# without the frame of the window, which has no manager here
convert "$folder/whole.png" -trim +repage -strip "$into/gtkwave.png"
