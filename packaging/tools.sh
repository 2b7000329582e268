#!/usr/bin/env bash
# tools.sh VENV REQUIREMENT...: a virtual environment with these packages from PyPI (or `-r FILE`), made anew when they
# change. Exit code 3, with words, where Python cannot make one or PyPI is not to be had.
set -euo pipefail
cd "$(dirname "$0")/.."
venv=$1
shift
wanted=$(printf '%s\n' "$@" && for word in "$@"; do [[ -f $word ]] && cat "$word"; done; true)
[[ -f $venv/wanted.txt && $(<"$venv/wanted.txt") == "$wanted" ]] && exit 0
rm -rf "$venv"
mkdir -p "$(dirname "$venv")"
if ! python3 -m venv "$venv" >/dev/null 2>&1; then
  echo "no virtual environment: Python 3.10 or newer with python3-venv (Debian package name) is needed" >&2
  rm -rf "$venv"
  exit 3
fi
if ! "$venv/bin/pip" install --quiet --disable-pip-version-check "$@"; then
  echo "pip could not install $*" >&2
  rm -rf "$venv"
  exit 3
fi
echo "$wanted" >"$venv/wanted.txt"
