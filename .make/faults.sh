# The faults suite in full, on the real firmware; what it finds goes to standard output as JSON.
# Without arguments the generated traces come first, 100,000 of each kind.
# usage: faults.sh [ARGUMENTS…]
set -eu
. .make/lib.sh
. .make/browsers.sh
want_playwright
want_chromium
sh .make/firmware.sh board >/dev/null

PATH=$PWD/.venv/bin:$PATH
export PATH
if [ $# = 0 ]; then
    WAX_TRACES=100000 WAX_STEPS=100000 pytest -q tests/control/test_black_channel.py \
        tests/control/test_hand_over.py \
        tests/firmware/test_line_black_channel.py::test_no_wrong_execution >&2
fi
exec python -m e2e.faults "$@"
