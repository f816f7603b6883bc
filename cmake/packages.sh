# SPDX-License-Identifier: BSD-3-Clause
# Sourced by drivers/quickstart.sh, tests/run.sh and .ci/run: packages of Debian and the settings of Open MPI.
# shellcheck shell=bash

stiffront_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '== %s\n' "$*"; }

# Packages of cmake/debian-packages.txt that are not installed, one a line.
missing_packages() {
  local package
  sed 's/#.*//' "$stiffront_root/cmake/debian-packages.txt" | while read -r package; do
    [ -n "$package" ] || continue
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || printf '%s\n' "$package"
  done
}

# Installs what is missing, or says what and how. What is missing for pictures alone does not stop anything.
require_packages() {
  local missing command needed
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    say "not a Debian system: going on with what is here; needed is what cmake/debian-packages.txt names"
    return 0
  fi
  mapfile -t missing < <(missing_packages)
  [ ${#missing[@]} -gt 0 ] || return 0
  say "missing Debian packages: ${missing[*]}"
  command="apt-get update && apt-get install -y --no-install-recommends ${missing[*]}"
  if [ "$(id -u)" = 0 ]; then
    install_packages "${missing[@]}" || true
  elif command -v sudo >/dev/null && { sudo -n true 2>/dev/null || { [ -t 0 ] && [ -z "${CI:-}" ]; }; }; then
    command="sudo sh -c '$command'"
    install_packages "${missing[@]}" || true
  else
    command="su -c '$command'"
  fi
  mapfile -t missing < <(missing_packages)
  [ ${#missing[@]} -gt 0 ] || return 0
  needed=$(printf '%s\n' "${missing[@]}" | grep -v '^python3' || true)
  if [ -z "$needed" ]; then
    say "going on without ${missing[*]}: no pictures. To install them: $command"
    return 0
  fi
  say "these packages could not be installed: ${missing[*]}"
  say "to install them, run: $command"
  return 1
}

install_packages() {
  local as_root=()
  [ "$(id -u)" = 0 ] || as_root=(sudo)
  "${as_root[@]}" apt-get update -qq </dev/null || say "apt-get update failed; trying with the lists that are here"
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -qy --no-install-recommends "$@" </dev/null
}

# Ranks may outnumber cores; Open MPI asks twice before it runs as root.
set_mpi_environment() {
  export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_hwloc_base_binding_policy=none OMPI_MCA_mpi_yield_when_idle=1
  if [ "$(id -u)" = 0 ]; then
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
  fi
}

# Compiles again only what changed, also across build folders.
use_compiler_cache() {
  if command -v ccache >/dev/null && [ -z "${CMAKE_CXX_COMPILER_LAUNCHER:-}" ]; then
    export CMAKE_CXX_COMPILER_LAUNCHER=ccache CCACHE_BASEDIR=$stiffront_root CCACHE_NOHASHDIR=1
  fi
}
