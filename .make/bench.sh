# The benchmarks; what they find goes to standard output as JSON.
# usage: bench.sh [ARGUMENTS…]
set -eu
. .make/lib.sh
. .make/browsers.sh
want_playwright
want_chromium

PATH=$PWD/.venv/bin:$PATH
export PATH
exec python -m e2e.bench "$@"
