#!/usr/bin/env bash
# Makes program.hex (some 10,000 cycles) and long.hex (some millions) of program.c, with gcc-riscv64-unknown-elf.
set -euo pipefail
cd "$(dirname "$0")"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
make() { # the file, then options
  riscv64-unknown-elf-gcc -march=rv32i -mabi=ilp32 -O1 -Wall -Wextra -ffreestanding -nostdlib -fno-pic \
    -Wl,--build-id=none,--no-warn-rwx-segments "${@:2}" -T link.ld start.S program.c -o "$work/program"
  riscv64-unknown-elf-objcopy -O binary "$work/program" "$work/bytes"
  od -An -v -tx4 -w4 --endian=little "$work/bytes" | tr -d ' ' >"$1"
}
make program.hex
make long.hex -DPRIMES=8000 -DNUMBERS=500
