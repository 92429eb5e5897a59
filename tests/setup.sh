#!/bin/sh
# Says what is missing to build and test, and installs what Debian has of it.
set -eu

for tool in cargo python3 cc; do
    if ! command -v "$tool" >/dev/null 2>&1; then
        echo "missing: $tool. Install Rust (rustup.rs), Python 3 and a C compiler first." >&2
        exit 1
    fi
done

missing=""
# `setup.sh test` also wants the browser in which the page of `rrf view` is tested, and what Blender's module loads
tested=""
if [ "${1:-}" = test ]; then
    tested="libgl1 libice6 libsm6 libx11-6 libxext6 libxfixes3 libxi6 libxkbcommon0 libxrender1"
    command -v chromium >/dev/null 2>&1 || tested="$tested chromium"
fi
for package in libopenblas-dev pkg-config $tested; do
    if ! dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed'; then
        missing="$missing $package"
    fi
done
# a Debian python3 without python3-venv makes environments without pip
if ! python3 -c 'import ensurepip, venv' 2>/dev/null; then
    missing="$missing python3-venv"
fi
[ -z "$missing" ] && exit 0

echo "missing Debian packages:$missing. Installing them."
sudo=""
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null 2>&1 || {
        echo "not root and no sudo: run 'apt-get install$missing' as root, then again." >&2
        exit 1
    }
    sudo="sudo"
fi
$sudo apt-get update -qq
# shellcheck disable=SC2086
DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y -qq $missing
