# The faults suite, on the real firmware.
# usage: faults.sh [ARGUMENTS…]
set -eu
. .make/lib.sh
python=.venv/bin/python
. .make/browsers.sh
want_playwright
want_chromium
sh .make/firmware.sh board >/dev/null

PATH=$PWD/.venv/bin:$PATH
export PATH
exec python -m e2e.faults "$@"
