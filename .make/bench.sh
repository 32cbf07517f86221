# The benchmarks.
# usage: bench.sh [ARGUMENTS…]
set -eu
. .make/lib.sh
python=.venv/bin/python
. .make/browsers.sh
want_playwright
want_chromium

PATH=$PWD/.venv/bin:$PATH
export PATH
exec python -m e2e.bench "$@"
