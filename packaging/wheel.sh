#!/usr/bin/env bash
# wheel.sh BUILD OUT: the Python package as a wheel in OUT, with library, headers and tool inside.
#
# BUILD is target/release (a wheel for this machine) or target/x86_64-unknown-linux-gnu/release, as packaging/portable.sh
# leaves it (a wheel for manylinux2014). maturin stands in build/release-venv (portable) or build/wheel-venv.
set -euo pipefail
cd "$(dirname "$0")/.."
build=$1 out=$(realpath -m "$2")

case $build in
target/release)
  venv=build/wheel-venv
  packaging/tools.sh "$venv" "$(grep maturin packaging/requirements.txt)"
  options=(--compatibility linux)
  ;;
target/x86_64-unknown-linux-gnu/release)
  venv=build/release-venv
  packaging/tools.sh "$venv" -r packaging/requirements.txt
  options=(--compatibility manylinux2014 --zig --target x86_64-unknown-linux-gnu)
  ;;
*)
  echo "wheel: BUILD = $build: must be one of the two" >&2
  exit 1
  ;;
esac

install -D -m 755 -t python/mepc/lib "$build/libmepc.so"
install -D -m 644 -t python/mepc/include include/mepc.h include/mepc.f90
mkdir -p "$out"
rm -f "$out"/mepc-*.whl
(
  PATH=$PWD/$venv/bin:$PATH
  cd python
  maturin build --quiet --release --locked "${options[@]}" --out "$out"
)
ls "$out"/mepc-*.whl
