#!/bin/sh
# run.sh TARGET [SECONDS [LIBFUZZER OPTION …]]: fuzzes a target on the stable toolchain; 0 seconds never end.
# What it finds is kept in found/TARGET; corpus/TARGET is only read. `run.sh merge TARGET` takes what the working corpus
# adds to the coverage into corpus/TARGET.
set -eu
cd "$(dirname "$0")"
export RUSTC_BOOTSTRAP=1
export RUSTFLAGS="--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=1"
merge=
if [ "$1" = merge ]; then merge=yes; shift; fi
target=$1
seconds=${2:-60}
[ $# -gt 2 ] && { shift 2; } || set --
case $target in
vcd | fst | ghw) features=--no-default-features ;;
*) features= ;;
esac
# shellcheck disable=SC2086
cargo build --quiet --release $features --bin "$target" --target "$(rustc -vV | sed -n 's/host: //p')"
binary=target/$(rustc -vV | sed -n 's/host: //p')/release/$target
mkdir -p "work/$target" "found/$target"
if [ -n "$merge" ]; then
    exec "$binary" -merge=1 "corpus/$target" "work/$target"
fi
exec "$binary" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -max_len=4096 -print_final_stats=1 \
    -artifact_prefix="found/$target/" "$@" "work/$target" "corpus/$target"
