# The branches of what keeps the robot standing; those that no example takes go to the output.
# usage: coverage.sh
set -eu
. .make/lib.sh

exec .venv/bin/python -m e2e.mutants.branches
