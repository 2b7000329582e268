#!/usr/bin/env bash
# The virtual environment of the hosts, build/hosts-venv: made from requirements.txt unless it is up to date, and the
# package `mepc` put into it.
set -euo pipefail
cd "$(dirname "$0")/.."
venv=build/hosts-venv
wanted=hosts/requirements.txt
if ! python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
  echo "hosts/setup.sh: please install Python 3.11 or newer" >&2
  exit 1
fi
if ! python3 -c 'import venv, ensurepip' 2>/dev/null; then
  echo "hosts/setup.sh: please install python3-venv (Debian package name)" >&2
  exit 1
fi
if ! cmp -s "$wanted" "$venv/installed.txt"; then
  echo "making $venv (some 1.8 GB)"
  rm -rf "$venv"
  python3 -m venv "$venv"
  "$venv/bin/pip" install --quiet --disable-pip-version-check --requirement "$wanted"
  cp "$wanted" "$venv/installed.txt"
fi
# The package `mepc` as it is built now (`make library cli`), and the folders whose modules scripts of others import.
packaging/wheel.sh target/release build/wheel >/dev/null
"$venv/bin/pip" install --quiet --disable-pip-version-check --no-deps --force-reinstall build/wheel/mepc-*.whl
printf "$PWD/%s\n" hosts hosts/kratos studies studies/lap_joint >"$(echo "$venv"/lib/python3.*/site-packages)/folders.pth"
