#!/usr/bin/env bash
# The virtual environment of the distributed host, build/mpi-venv: made from requirements.txt unless it is up to date,
# and the package `mepc` put into it. The wheels want Python 3.12 or newer: python3 itself, one beside it, or one of
# pyenv's versions.
set -euo pipefail
cd "$(dirname "$0")/../.."
venv=build/mpi-venv
wanted=hosts/dolfinx/requirements.txt

if ! command -v cc >/dev/null; then
  echo "hosts/dolfinx/setup.sh: please install a C compiler (cc); dolfinx compiles its forms with it" >&2
  exit 1
fi
# The package `mepc` as it is built now (`make library cli`), and the folders whose modules scripts of others import.
bring() {
  packaging/wheel.sh target/release build/wheel >/dev/null
  "$venv/bin/pip" install --quiet --disable-pip-version-check --no-deps --force-reinstall build/wheel/mepc-*.whl
  printf "$PWD/%s\n" studies studies/lap_joint >"$(echo "$venv"/lib/python3.*/site-packages)/folders.pth"
}

if cmp -s "$wanted" "$venv/installed.txt"; then
  bring
  exit 0
fi

usable() {
  "$1" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 12))' 2>/dev/null
}
found=
for candidate in python3 python3.1{2,3,4} "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3.*/bin/python3; do
  if path=$(command -v "$candidate") && usable "$path"; then
    found=$path
    break
  fi
done
if [ -z "$found" ]; then
  echo "hosts/dolfinx/setup.sh: no Python 3.12 or newer (with venv) as python3, python3.12 to python3.14, or in pyenv's" \
    "versions: please install one" >&2
  exit 1
fi
echo "making $venv (some 600 MB) with $found"
rm -rf "$venv"
"$found" -m venv "$venv"
"$venv/bin/pip" install --quiet --disable-pip-version-check --requirement "$wanted"
cp "$wanted" "$venv/installed.txt"
bring
