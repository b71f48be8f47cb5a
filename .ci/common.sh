# What .ci/run and .ci/full share; both source it. It leaves the shell in the repository's folder.
set -euo pipefail
cd "$(dirname "$0")/.."
repository=$PWD
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The solvers use small matrices, on which threads of BLAS only wait for each other.
export OPENBLAS_NUM_THREADS=1 MPLBACKEND=Agg PIP_DISABLE_PIP_VERSION_CHECK=1
# Workers of pytest share the modules that one of them has compiled.
unset PYTHONDONTWRITEBYTECODE

# The n-th block of shell commands in the README.
readme_block() {
    awk -v wanted="$1" '/^```sh$/ {n++; inside = 1; next} /^```$/ {inside = 0}
                        inside && n == wanted' README.md
}

clone() { git clone --quiet "$repository" "$1"; }

# debian PACKAGE...: install what is missing of the packages that a section needs.
debian() {
    local missing
    missing=$({ dpkg-query -W -f '${db:Status-Status} ${Package}\n' "$@" 2> /dev/null || true; } |
        awk '$1 == "installed" {print $2}' | sort | comm -13 - <(printf '%s\n' "$@" | sort))
    [ -n "$missing" ] || return 0
    apt-get update -qq
    # shellcheck disable=SC2086  # one word a package
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq $missing > /dev/null
}

# kernels COMMAND...: run a command with OpenBLAS's kernels for AVX2 and, where the processor has
# AVX-512, with those too: their sums differ in the last bit. NumPy and SciPy bring a copy of
# OpenBLAS each, and both heed the variable.
kernels() {
    if ! grep -qsw avx2 /proc/cpuinfo; then
        "$@"
        return
    fi
    OPENBLAS_CORETYPE=Haswell "$@"
    if grep -qsw avx512f /proc/cpuinfo; then OPENBLAS_CORETYPE=SkylakeX "$@"; fi
}

# What gmsh's wheel is linked with.
gmsh=(libglu1-mesa libgl1 libopengl0 libxrender1 libxcursor1 libxft2 libxinerama1)

# section NAME COMMAND...: run a command with its output in a file, which a failure shows at once.
# Its time on the clock and on the processors is shown either way.
section() {
    local log="$work/$1.log" TIMEFORMAT='%R s, processors %U + %S s'
    { time (set -ex; "${@:2}"); } > "$log" 2>&1 &
    if wait $!; then
        printf '=== %s: %s\n' "$1" "$(tail -n 1 "$log")"
    else
        touch "$work/failed"
        printf '=== %s FAILED\n%s\n=== %s failed, see above\n' "$1" "$(cat "$log")" "$1"
    fi
}

# none MESSAGE: fail if there are lines to read, and show them.
none() {
    local lines
    lines=$(cat)
    [ -z "$lines" ] || { printf '%s\n%s\n' "$1" "$lines"; false; }
}

# lanes FUNCTION FUNCTION: run the sections of two functions side by side, one for each core.
lanes() {
    "$1" &
    local other=$!
    "$2"
    wait "$other"
}

finish() {
    if [ -e "$work/failed" ]; then
        echo "=== FAILED after $SECONDS s"
        exit 1
    fi
    echo "=== passed after $SECONDS s"
}
