#!/usr/bin/env bash
# Builds CalculiX from Debian's own source package with support for external behaviours: build/calculix/ccx.
# Needs apt-get, gcc, gfortran, make and patch; takes about 3 minutes. Installs the libraries it needs when root.
set -euo pipefail
cd "$(dirname "$0")/../.."
target=$PWD/build/calculix
[[ -x $target/ccx ]] && { echo "already there: $target/ccx"; exit 0; }

for program in apt-get gcc gfortran make patch; do
  command -v "$program" >/dev/null || { echo "build.sh: please install $program" >&2; exit 1; }
done
needed=(libspooles-dev libarpack2-dev liblapack-dev)
missing=()
for package in "${needed[@]}"; do
  dpkg -s "$package" >/dev/null 2>&1 || missing+=("$package")
done
if ((${#missing[@]})); then
  if [[ $(id -u) != 0 ]]; then
    echo "build.sh: please install ${missing[*]}" >&2
    exit 1
  fi
  echo "installing ${missing[*]}"
  apt-get update -qq
  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
fi

# A list of sources of its own: the machine's stay as they are.
. /etc/os-release
mkdir -p "$target/apt/sources" "$target/apt/lists/partial"
echo "deb-src http://deb.debian.org/debian $VERSION_CODENAME main" >"$target/apt/sources/source.list"
apt_own=(apt-get -qq -o Dir::Etc::sourcelist=/dev/null -o "Dir::Etc::sourceparts=$target/apt/sources"
  -o "Dir::State::lists=$target/apt/lists")
(cd "$target" && "${apt_own[@]}" update && "${apt_own[@]}" source --download-only calculix-ccx)

rm -rf "$target/source"
mkdir "$target/source"
tar -xf "$target"/calculix-ccx_*.orig.tar.* -C "$target/source"
tar -xf "$target"/calculix-ccx_*.debian.tar.* -C "$target/source"
while read -r patch; do
  patch -s -p1 -d "$target/source/CalculiX" <"$target/source/debian/patches/$patch"
done <"$target/source/debian/patches/series"

source=$(echo "$target"/source/CalculiX/ccx_*/src)
version=$(basename "$(dirname "$source")")
echo "building $version"
flags='-O2 -w -I/usr/include/spooles -DARCH=Linux -DSPOOLES -DARPACK -DMATRIXSTORAGE -DUSE_MT=1'
make -C "$source" -j"$(nproc)" CC=gcc FC=gfortran CFLAGS="$flags -DCALCULIX_EXTERNAL_BEHAVIOURS_SUPPORT" \
  FFLAGS='-O2 -w -fallow-argument-mismatch' LDFLAGS=-ldl >"$target/build.log" 2>&1 ||
  { tail -20 "$target/build.log" >&2; exit 1; }
nm -D "$source/$version" | grep -q dlopen || { echo "build.sh: external behaviours are not in it" >&2; exit 1; }
cp "$source/$version" "$target/ccx"
echo "built $target/ccx"
