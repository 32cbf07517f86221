# Renew requirements.lock, requirements-dev.lock and .make/node.lock: the newest versions that
# pyproject.toml allows, for every platform and Python from 3.11 on.
set -eu
. .make/lib.sh

python=${PYTHON:-python3}
tools=$(mktemp -d)
trap 'rm -rf "$tools"' EXIT
"$python" -m venv "$tools/venv"
patiently "$tools/venv/bin/pip" install -q --disable-pip-version-check 'uv>=0.9,<1'

# usage: compile OUTPUT WHAT ARGUMENTS…
compile() {
    output=$1
    {
        echo "# $2. Made by \`make lock\`; do not edit."
        shift 2
        patiently "$tools/venv/bin/uv" pip compile --quiet --universal --python-version 3.11 \
            --generate-hashes --no-header --no-annotate --upgrade "$@"
    } >"$tools/lock"
    cp "$tools/lock" "$output"
    say "$output: $(grep -c == "$output") packages"
}

compile requirements-dev.lock "What \`make test\` installs: the packages of \`make run\` and the tools" \
    pyproject.toml --group build --group dev
compile requirements.lock "What \`make run\` installs" \
    pyproject.toml --group build --constraint requirements-dev.lock
compile .make/node.lock "Node, for machines that have no suitable one" --group node
