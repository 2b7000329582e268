#!/usr/bin/env bash
# Every way to use the installed library, as its user would: built against a prefix that was moved after `make install`,
# and run. Needs target/release (`make library cli`). All of it happens in build/downstream.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
cd "$here/../.."
root=$PWD
work=$root/build/downstream
mkdir -p "$work"
# The crates that the Rust consumer needs are kept from one run to the next.
find "$work" -mindepth 1 -maxdepth 1 ! -name target -exec rm -rf {} +
log=$work/log.txt

# step NAME COMMAND...: runs it; the output is shown when it fails.
passed=0
step() {
  local name=$1 outcome=0
  shift
  # Not within a condition: there, a failing command in a function would not end it.
  set +e
  (
    set -e
    "$@"
  ) >"$log" 2>&1
  outcome=$?
  set -e
  if ((outcome)); then
    cat "$log" >&2
    echo "downstream: $name failed" >&2
    exit 1
  fi
  passed=$((passed + 1))
  echo "downstream: $name: $(tail -1 "$log")"
}

# refuse WORDS COMMAND...: the command must not succeed.
refuse() {
  local words=$1
  shift
  if "$@"; then
    echo "$words"
    return 1
  fi
}

# copy NAME: a project beside the prefix.
copy() {
  cp -r "$here/$1" "$work/$1"
  cd "$work/$1"
}

prefix=$work/prefix
CFLAGS=(-std=c99 -O1 -Wall -Wextra -Wpedantic -Werror)
export PKG_CONFIG_PATH=$prefix/lib/pkgconfig
# Cargo and the caller's shell point at other builds.
unset LD_LIBRARY_PATH LIBRARY_PATH CPATH

# A package is made below DESTDIR, and what is installed may be moved: the consumers see neither of these paths.
moved_prefix() {
  DESTDIR=$work/stage packaging/install.sh target/release /opt/somewhere
  mv "$work/stage/opt/somewhere" "$prefix"
  refuse "a path of the place of installation" grep -rI -e "$work/stage" -e /opt/somewhere "$prefix"
  "$prefix/bin/mepc" --version
}

c_shared() {
  copy c
  cc "${CFLAGS[@]}" main.c $(pkg-config --cflags --libs mepc) -lm -Wl,-rpath,"$prefix/lib" -o main
  ./main
}

c_static() {
  cd "$work/c"
  cc "${CFLAGS[@]}" main.c $(pkg-config --cflags mepc) $(pkg-config --variable=static mepc) -o static
  refuse "the shared library is linked" grep mepc <(ldd static)
  ./static
  # Without any shared library. (The C library warns that names of hosts and users would need some; they are not asked for.)
  cc "${CFLAGS[@]}" -static main.c $(pkg-config --static --cflags --libs mepc) -o all_static
  ./all_static
}

# Linked by the path of the library; program and library then stand elsewhere.
c_moved() {
  mkdir -p "$work/moved/bin"
  cd "$work/c"
  cc "${CFLAGS[@]}" main.c -I../prefix/include ../prefix/lib/libmepc.so -lm -Wl,-rpath,'$ORIGIN/../lib' -o by_path
  mv by_path "$work/moved/bin"
  cp -a "$prefix/lib" "$work/moved/lib"
  cd /
  ldd "$work/moved/bin/by_path" | grep -F "$work/moved/bin/../lib/libmepc.so.0.1"
  "$work/moved/bin/by_path"
}

c89() {
  copy c89
  cc -std=c89 -Wall -Werror include.c $(pkg-config --cflags --libs mepc) -Wl,-rpath,"$prefix/lib" -o include
  ./include
  echo "-std=c89 -Wall -Werror"
}

cpp_cmake() {
  copy cpp
  cmake -S . -B build -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CXX_FLAGS="-Wall -Wextra -Werror"
  cmake --build build
  build/consumer_static
  build/consumer_mepc
}

# A version that is not this one must not be taken.
cmake_version() {
  mkdir -p "$work/version"
  cd "$work/version"
  local asked
  for asked in 0.0.9 0.2.0 1.0.0; do
    sed "s/mepc 0.1.0/mepc $asked/" "$here/cpp/CMakeLists.txt" >CMakeLists.txt
    if cmake -S . -B build -DCMAKE_PREFIX_PATH="$prefix" >out.txt 2>&1; then
      echo "CMake took the library for version $asked"
      return 1
    fi
    grep -q 'not accepted\|compatible with requested version' out.txt
  done
  echo "others are refused"
}

fortran_cmake() {
  copy fortran_cmake
  cmake -S . -B build -DCMAKE_PREFIX_PATH="$prefix"
  cmake --build build
  build/consumer
}

fortran_fpm() {
  copy fortran_fpm
  # The tool writes terminal control sequences; the last line is the program's.
  TERM=dumb "$work/venv/bin/fpm" run --link-flag "-L$prefix/lib -Wl,-rpath,$prefix/lib"
}

rust_crate() {
  cargo package --quiet --package mepc --no-verify --allow-dirty --target-dir "$work/target"
  mkdir -p "$work/mepc"
  tar -xzf "$work/target/package/mepc-$(packaging/version.sh).crate" --strip-components 1 -C "$work/mepc"
  copy rust
  cp "$root/Cargo.lock" .
  cargo run --quiet --target-dir "$work/target"
}

own_umat() {
  cargo build --quiet --package mepc --lib --no-default-features --features abaqus,mfront --target-dir "$work/target"
  copy own_umat
  local static
  static=$(pkg-config --variable=static mepc)
  cc "${CFLAGS[@]}" main.c $(pkg-config --cflags mepc) ${static/#*libmepc.a/$work/target/debug/libmepc.a} -o main
  ./main | grep own
  # Everything else of the frozen list is there.
  nm --defined-only "$work/target/debug/libmepc.a" 2>/dev/null | awk '$2 ~ /^[A-Z]$/ {print $3}' | sort -u >symbols.txt
  comm -13 symbols.txt <(sort "$root/tests/symbols.txt") >missing.txt
  diff missing.txt <(printf 'umat\numat_\n')
  echo "all faces but one"
}

python_wheel() {
  packaging/wheel.sh target/release "$work/wheel"
  python3 -m venv "$work/venv"
  "$work/venv/bin/pip" install --quiet --disable-pip-version-check -r "$here/requirements.txt" "$work"/wheel/*.whl
  cd "$work"
  "$work/venv/bin/mepc" --version
  "$work/venv/bin/python" -m mepc --library
  [[ $("$work/venv/bin/python" -m mepc --library) == "$work"/venv/lib/*/mepc/lib/libmepc.so ]]
  cc -std=c99 -I"$("$work/venv/bin/python" -m mepc --include)" -fsyntax-only "$here/c/main.c"
  "$work/venv/bin/python" -m pytest -q -p no:cacheprovider "$root/python/tests"
}

# Every program that the documentation shows.
listings() {
  MEPC_PREFIX=$prefix MEPC_CRATE=$work/mepc MEPC_TARGET=$work/target "$work/venv/bin/python" -m pytest -q \
    -p no:cacheprovider "$here/test_listings.py"
}

step "install, below DESTDIR and moved" moved_prefix
step "C, pkg-config, shared" c_shared
step "C, pkg-config, static" c_static
step "C, linked by path, moved" c_moved
step "C89, the header" c89
step "C++, CMake" cpp_cmake
step "CMake, versions" cmake_version
step "Fortran, CMake" fortran_cmake
step "Rust, the packaged crate" rust_crate
step "C, static without the UMAT face" own_umat
step "Python, the wheel" python_wheel
step "Fortran, fpm" fortran_fpm
step "the listings of the documentation" listings
echo "$passed passed, 0 failed"
