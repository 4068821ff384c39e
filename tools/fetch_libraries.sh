#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# tools/fetch_libraries.sh FOLDER: fills FOLDER with what `cmake --preset gl -DVOLUTE_DEPS_DIR=FOLDER` builds from, for a
# machine that has a compiler, CMake and the headers of OpenGL alone. Run it on Debian 12, as anybody: nothing is installed.
# Headers come from binary packages, the other libraries' sources from source packages; 20 MB are fetched.
set -euo pipefail
[ $# -eq 1 ] || { echo "usage: tools/fetch_libraries.sh FOLDER" >&2; exit 2; }
mkdir -p "$1"
folder=$(cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
headers=(libexpected-dev libfmt-dev nlohmann-json3-dev libcli11-dev libeigen3-dev)
sources=(onetbb highway zlib libpng1.6 libyaml libzstd libepoxy)

mkdir -p "$work/lists/partial" "$work/headers" "$work/sources"
release=$(. /etc/os-release && echo "$VERSION_CODENAME")
key=/usr/share/keyrings/debian-archive-keyring.gpg
printf '%s [signed-by=%s] http://deb.debian.org/debian %s main\n' deb "$key" "$release" deb-src "$key" "$release" >"$work/sources.list"
apt=(apt-get -qq -o "Dir::Etc::sourcelist=$work/sources.list" -o Dir::Etc::sourceparts=- -o "Dir::State::Lists=$work/lists"
  -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache= -o APT::Sandbox::User=)
"${apt[@]}" update
(cd "$work/headers" && "${apt[@]}" download "${headers[@]}")
(cd "$work/sources" && "${apt[@]}" source --download-only --tar-only "${sources[@]}")

for package in "$work"/headers/*.deb; do dpkg -x "$package" "$work/root"; done
mkdir -p "$folder/include"
cp -r "$work"/root/usr/include/. "$folder/include/"
for name in "${sources[@]}"; do
  rm -rf "${folder:?}/$name"
  mkdir -p "$folder/$name"
  tar -xf "$work/sources/${name}"_*.orig.tar.* -C "$folder/$name" --strip-components=1
  # Nothing that is built is in these.
  rm -rf "${folder:?}/$name"/{tests,test,docs,doc,g3doc,examples,contrib,programs,debian}
done
mkdir -p "$folder/libepoxy/generated"
for registry in gl egl; do
  python3 "$folder/libepoxy/src/gen_dispatch.py" --outputdir="$folder/libepoxy/generated" \
    --source --header "$folder/libepoxy/registry/$registry.xml"
done
mkdir -p "$folder/libepoxy/generated/src" "$folder/libepoxy/generated/include/epoxy"
mv "$folder"/libepoxy/generated/*.c "$folder/libepoxy/generated/src/"
mv "$folder"/libepoxy/generated/*.h "$folder/libepoxy/generated/include/epoxy/"
du -sh "$folder"
