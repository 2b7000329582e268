#!/usr/bin/env bash
# Installs the programs that are named (and missing): with apt-get when root, otherwise it says what is missing. Also
# checks that Rust is new enough.
set -euo pipefail

minimum_rust=1.89

declare -A package=([cc]=gcc [c++]=g++ [gfortran]=gfortran [nm]=binutils [valgrind]=valgrind [cmake]=cmake
  [pkg-config]=pkg-config [python3]=python3)
missing=()
for program in "$@"; do
  command -v "$program" >/dev/null || missing+=("${package[$program]}")
done
# A module of Python that Debian keeps apart.
if [[ " $* " == *" python3 "* ]] && ! python3 -c 'import ensurepip, venv' 2>/dev/null; then
  missing+=(python3-venv)
fi

if ((${#missing[@]})); then
  if [[ $(id -u) == 0 ]] && command -v apt-get >/dev/null; then
    echo "setup: installing ${missing[*]}"
    export DEBIAN_FRONTEND=noninteractive
    log=$(mktemp)
    if ! { apt-get update -qq && apt-get install -y -qq --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
      cat "$log" >&2
      echo "setup: apt-get could not install ${missing[*]}" >&2
      exit 1
    fi
    rm -f "$log"
  else
    echo "setup: please install ${missing[*]} (Debian package names), for example:" >&2
    echo "  sudo apt-get install ${missing[*]}" >&2
    exit 1
  fi
fi

if ! command -v cargo >/dev/null; then
  echo "setup: please install Rust $minimum_rust or newer (https://rustup.rs)" >&2
  exit 1
fi
have=$(rustc --version | cut -d' ' -f2)
if [[ $(printf '%s\n' "$minimum_rust" "$have" | sort -V | head -n1) != "$minimum_rust" ]]; then
  echo "setup: Rust $have is too old, $minimum_rust or newer is needed" >&2
  exit 1
fi
