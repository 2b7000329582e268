#!/usr/bin/env bash
# Whether library and tool compile for other systems: `cargo check` for each of their targets that is installed.
set -euo pipefail
cd "$(dirname "$0")/.."
installed=$(ls "$(rustc --print sysroot)/lib/rustlib")
for target in x86_64-pc-windows-gnu x86_64-pc-windows-msvc x86_64-apple-darwin aarch64-apple-darwin; do
  if grep -qx "$target" <<<"$installed"; then
    cargo check --quiet --locked --package mepc --package mepc-cli --lib --bins --target "$target"
    echo "cross-check: $target compiles"
  else
    echo "cross-check: $target skipped (rustup target add $target)"
  fi
done
