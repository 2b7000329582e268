#!/usr/bin/env bash
# Makes the virtual environment of the hosts, build/hosts-venv, from requirements.txt, unless it is up to date.
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
cmp -s "$wanted" "$venv/installed.txt" && exit 0
echo "making $venv (some 1.8 GB)"
rm -rf "$venv"
python3 -m venv "$venv"
"$venv/bin/pip" install --quiet --disable-pip-version-check --requirement "$wanted"
cp "$wanted" "$venv/installed.txt"
