#!/bin/sh
# The notebooks' environment: sh notebooks/setup.sh FOLDER. Python packages into FOLDER, and from
# Debian the LLVM library that Mitsuba's llvm variants compile their kernels with.
set -eu
cd "$(dirname "$0")/.."
folder=$1

llvm=libllvm19
if ! dpkg-query -W -f='${Status}' "$llvm" 2>/dev/null | grep -q 'install ok installed'; then
    sudo=""
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null 2>&1 || {
            echo "not root and no sudo: run 'apt-get install $llvm' as root, then again." >&2
            exit 1
        }
        sudo="sudo"
    fi
    echo "installing Debian package $llvm"
    $sudo apt-get update -qq
    DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y -qq "$llvm"
fi

python3 -m venv "$folder"
"$folder/bin/python" -m pip install --quiet --requirement notebooks/requirements.txt
# Dr.Jit would take any LLVM that it finds: name one
dpkg-query -L "$llvm" | grep -E '/libLLVM[^/]*\.so[.0-9]*$' | sort | tail -n 1 >"$folder/libllvm"
