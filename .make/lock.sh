# Renew requirements.lock, requirements-dev.lock and the locks in .make: the newest
# versions that pyproject.toml allows, for every platform and Python from 3.11 on.
set -eu
. .make/lib.sh

# usage: compile OUTPUT WHAT ARGUMENTS…
compile() {
    output=$1
    {
        echo "# $2. Made by \`make lock\`; do not edit."
        shift 2
        # Keep the project's settings, but write none of their constraints.
        UV_SYSTEM_CERTS=1 .venv/bin/uv pip compile --quiet --universal --python-version 3.11 \
            --generate-hashes --no-header --no-annotate --upgrade "$@"
    } >.cache/lock
    mv .cache/lock "$output"
    say "$output: $(grep -c == "$output") packages"
}

mkdir -p .cache
compile requirements-dev.lock "What \`make test\` installs: the packages of \`make run\` and the tools" \
    pyproject.toml --group build --group dev
compile requirements.lock "What \`make run\` installs" \
    pyproject.toml --group build --constraint requirements-dev.lock
compile .make/node.lock "Node, for machines that have no suitable one" --group node
compile .make/fuzz.lock "What \`make fuzz\` installs: atheris, where there is one" --group fuzz
compile .make/uv.txt "uv, which installs the other packages" --group uv
