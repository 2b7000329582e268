#!/usr/bin/env bash
# The installed tree for Linux on x86-64 as an archive in dist/, from what packaging/portable.sh built, and the checksums
# of all that is in dist/.
set -euo pipefail
cd "$(dirname "$0")/.."
name=mepc-$(packaging/version.sh)-linux-x86_64
stage=build/dist
rm -rf "$stage"
mkdir -p dist
DESTDIR=$PWD/$stage packaging/install.sh target/x86_64-unknown-linux-gnu/release "/$name"
# The same bytes from the same tree: names in order, one owner, one time.
tar --directory "$stage" --sort=name --owner=0 --group=0 --numeric-owner --mtime=@0 --create "$name" |
  gzip --no-name -9 >"dist/$name.tar.gz"
(cd dist && rm -f SHA256SUMS && sha256sum -- * >SHA256SUMS && cat SHA256SUMS)
