#!/bin/sh
# Installs what the comparison with other programs needs: Mitsuba 3 into .venv-peers, and from
# Debian the LLVM library that Mitsuba's llvm variants compile their kernels with.
set -eu
cd "$(dirname "$0")/../.."

as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        "$@"
    elif command -v sudo >/dev/null 2>&1; then
        sudo "$@"
    else
        echo "not root and no sudo: run '$*' as root, then this again." >&2
        exit 1
    fi
}

installed() {
    dpkg-query -W -f='${Status}' "$1" 2>/dev/null | grep -q 'install ok installed'
}

# the newest that Debian 12 and 13 both have, then whatever else Dr.Jit can load; one that happens to be
# installed is not taken before it: with LLVM 15 kernels do not compile on newer processors
candidates="libllvm19 libllvm20 libllvm18 libllvm17 libllvm16 libllvm15"
llvm="" missing="" listed=""
python3 -c 'import ensurepip, venv' 2>/dev/null || missing="python3-venv"
for package in $candidates; do
    if installed "$package"; then llvm=$package; break; fi
    [ -n "$listed" ] || as_root apt-get update -qq
    listed=yes
    if apt-cache show "$package" >/dev/null 2>&1; then
        llvm=$package missing="$missing $package"
        break
    fi
done
[ -n "$llvm" ] || { echo "no package of: $candidates" >&2; exit 1; }
if [ -n "$missing" ]; then
    [ -n "$listed" ] || as_root apt-get update -qq
    echo "installing Debian packages: $missing"
    # shellcheck disable=SC2086
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq $missing
fi

[ -x .venv-peers/bin/python ] || python3 -m venv .venv-peers
.venv-peers/bin/python -m pip install --quiet --requirement tests/peers/requirements.txt

# Dr.Jit would take any LLVM that it finds; the measurement names one
library=$(dpkg-query -L "$llvm" | grep -E '/libLLVM[^/]*\.so[.0-9]*$' | sort | tail -n 1)
[ -e "$library" ] || { echo "$llvm has no libLLVM shared library" >&2; exit 1; }
printf '%s\n' "$library" > .venv-peers/libllvm
DRJIT_LIBLLVM_PATH=$library .venv-peers/bin/python - <<'PYTHON'
import drjit, mitsuba
mitsuba.set_variant("llvm_ad_rgb")
assert drjit.sum(mitsuba.Float([1, 2, 3])) == 6
print("Mitsuba", mitsuba.__version__, "llvm_ad_rgb works")
PYTHON
