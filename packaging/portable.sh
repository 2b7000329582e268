#!/usr/bin/env bash
# Library and tool for Linux on x86-64 with any C library from glibc 2.17 (2012) on, built by zig's linker from PyPI, in
# target/x86_64-unknown-linux-gnu/release. Skipped, with words, where zig is not to be had (exit code 3).
set -euo pipefail
cd "$(dirname "$0")/.."

newest_glibc=2.17
target=x86_64-unknown-linux-gnu
out=target/$target/release

if ! packaging/tools.sh build/release-venv -r packaging/requirements.txt; then
  echo "portable: skipped, no zig here" >&2
  exit 3
fi
# cargo-zigbuild and zig stand in the virtual environment.
PATH=$PWD/build/release-venv/bin:$PATH cargo zigbuild --release --locked --target "$target.$newest_glibc" \
  --package mepc --package mepc-cli

for file in "$out/libmepc.so" "$out/mepc"; do
  needs=$(objdump -T "$file" | grep -o 'GLIBC_[0-9.]*' | sort -uV | tail -1)
  if [[ $(printf '%s\n' "$needs" "GLIBC_$newest_glibc" | sort -V | tail -1) != "GLIBC_$newest_glibc" ]]; then
    echo "portable: $file needs $needs, newer than GLIBC_$newest_glibc" >&2
    exit 1
  fi
  echo "portable: $file needs $needs at most"
done
cargo xtask symbols --check --library "$out/libmepc.so"
