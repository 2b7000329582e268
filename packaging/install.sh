#!/usr/bin/env bash
# Installs what was built: libraries with their links, headers, files for pkg-config, CMake and fpm, the tool with its manual
# pages and completions, licences. All of it may be moved afterwards.
#
#   packaging/install.sh BUILD PREFIX [LIBDIR]     e.g. target/release /usr/local lib
#
# BUILD holds libmepc.so, libmepc.a and mepc. DESTDIR (environment) goes before PREFIX: files are put there, for packagers.
set -euo pipefail

build=$(realpath "$1") prefix=$2 libdir=${3:-lib}
cd "$(dirname "$0")/.."
if [[ $prefix != /* ]]; then
  echo "install: PREFIX = $prefix: must be an absolute path" >&2
  exit 1
fi
for file in libmepc.so libmepc.a mepc; do
  if [[ ! -f $build/$file ]]; then
    echo "install: $build/$file is not there: run \`make library cli\` first" >&2
    exit 1
  fi
done

version=$(packaging/version.sh)
interface=${version%.*}
root=${DESTDIR:-}$prefix
lib=$root/$libdir
# The way from $libdir/pkgconfig up to the prefix.
up=$(realpath -ms --relative-to="/$libdir/pkgconfig" /)

# fill FILE PLACE: a template with its names replaced.
fill() {
  install -d "$2"
  sed -e "s|@VERSION@|$version|g; s|@INTERFACE@|$interface|g; s|@LIBDIR@|$libdir|g; s|@UP@|$up|g" \
    "packaging/$1.in" >"$2/$1"
  chmod 644 "$2/$1"
}

install -D -m 755 "$build/libmepc.so" "$lib/libmepc.so.$version"
ln -sf "libmepc.so.$version" "$lib/libmepc.so.$interface"
ln -sf "libmepc.so.$interface" "$lib/libmepc.so"
install -D -m 644 "$build/libmepc.a" "$lib/libmepc.a"
strip --strip-debug "$lib/libmepc.a"
install -D -m 644 -t "$root/include" include/mepc.h include/mepc.f90
fill mepc.pc "$lib/pkgconfig"
fill mepcConfig.cmake "$lib/cmake/mepc"
fill mepcConfigVersion.cmake "$lib/cmake/mepc"
fill fpm.toml "$root/share/fpm/mepc"
install -D -m 644 -t "$root/share/fpm/mepc/src" include/mepc.f90

install -D -m 755 "$build/mepc" "$root/bin/mepc"
install -d "$root/share/man/man1"
"$build/mepc" man "$root/share/man/man1"
chmod 644 "$root"/share/man/man1/mepc*.1
for shell in bash:bash-completion/completions/mepc zsh:zsh/site-functions/_mepc fish:fish/vendor_completions.d/mepc.fish; do
  file=$root/share/${shell#*:}
  install -d "$(dirname "$file")"
  "$build/mepc" completions "${shell%%:*}" >"$file"
done

install -D -m 644 -t "$root/share/licenses/mepc" LICENSE-MIT LICENSE-APACHE
python3 packaging/third_party.py >"$root/share/licenses/mepc/THIRD-PARTY.txt"
chmod 644 "$root/share/licenses/mepc/THIRD-PARTY.txt"
echo "mepc $version is in $root"
