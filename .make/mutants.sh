# Small faults in what keeps the robot standing; what the tests do not notice goes to the output.
# usage: mutants.sh [ARGUMENTS…]
set -eu
. .make/lib.sh
sh .make/firmware.sh library >/dev/null # there is a compiler, or a sentence that says what to do

exec .venv/bin/python -m e2e.mutants "$@"
