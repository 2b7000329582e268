#!/usr/bin/env bash
# What an Abaqus user deploys, in build/abaqus: one relocatable object per product, and the link test of both ways to load
# the library. Needs target/release/libmepc.a and libmepc.so (`make library`).
set -euo pipefail
cd "$(dirname "$0")/.."

out=build/abaqus
archive=target/release/libmepc.a
mkdir -p "$out"

# object FILE SYMBOL...: everything the symbols need in one object, and nothing else of it to be seen.
object() {
  local file=$1 symbol pull=() keep=()
  shift
  for symbol; do
    pull+=(-u "$symbol")
    keep+=("--keep-global-symbol=$symbol")
  done
  ld -r --gc-sections "${pull[@]}" -o "$file" "$archive"
  # The standard library brings its compiler's own sections along.
  objcopy --strip-debug --remove-section=.llvmbc --remove-section=.llvmcmd "${keep[@]}" "$file"
  local seen
  seen=$(readelf --symbols --wide "$file" | awk '($5 == "GLOBAL" || $5 == "WEAK") && $7 != "UND" {print $8}' | sort | xargs)
  if [[ $seen != "$(printf '%s\n' "$@" | sort | xargs)" ]]; then
    echo "abaqus: $file shows $seen, not $*" >&2
    exit 1
  fi
  echo "$file: $seen, $(du -h "$file" | cut -f1)"
}

# try NAME FLAG...: the stand-in for Abaqus, linked with these, gives the closed form.
try() {
  local name=$1
  shift
  gfortran -cpp -std=f2018 -O1 -Wall -Werror -fimplicit-none hosts/abaqus/stand_in.f90 "$@" -o "$out/$name"
  echo "$name: $(MEPC_LIBRARY=$PWD/target/release/libmepc.so "$out/$name")"
}

object "$out/mepc-standard.o" fric_ uinter_
object "$out/mepc-explicit.o" vfric_ vfriction_
try stand_in_standard "$out/mepc-standard.o" -ldl -lpthread
try stand_in_explicit -DEXPLICIT "$out/mepc-explicit.o" -ldl -lpthread

"${CC:-cc}" -std=c99 -O2 -Wall -Wextra -Wpedantic -Werror -c hosts/abaqus/shim.c -o "$out/shim.o"
try stand_in_standard_shim "$out/shim.o" -ldl -lpthread
try stand_in_explicit_shim -DEXPLICIT "$out/shim.o" -ldl -lpthread
