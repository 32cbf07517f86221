# The branches of what keeps the robot standing, in all three languages; those that no example takes
# go to the output.
# usage: coverage.sh
set -u
. .make/lib.sh
PATH=$PWD/.venv/bin:$PATH
PYTHON=$PWD/.venv/bin/python
export PATH PYTHON

status=0
python -m e2e.mutants.branches || status=1
npm run --silent --prefix web coverage || status=1
exit $status
