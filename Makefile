# The work is in .make/; every target installs what it needs first.

help: ## this list
	@sed -n 's/^\([a-z]*\):.*## /make \1	/p' Makefile | expand -t 14

run: ## install what is missing, build the page, serve it: make run ARGS="--config config/wax.toml"
	@sh .make/install.sh run
	@exec .venv/bin/wax $(ARGS)

test: ## all checks and tests, browsers included
	@sh .make/test.sh

check: ## lint, format and strict types of both languages
	@sh .make/install.sh check
	@sh .make/check.sh

bench: ## the benchmarks beside a stock aiortc server: make bench ARGS="--only memory"
	@sh .make/install.sh test
	@sh .make/bench.sh $(ARGS)

lab: ## the thesis's chapter 5 over shaped networks, with a report: make lab ARGS="--only E3"
	@sh .make/install.sh test
	@sh .make/lab.sh $(ARGS)

goals: ## what is promised, beside stock aiortc and LiveKit: make goals ARGS="--only modem"
	@sh .make/install.sh test
	@sh .make/lab.sh --goals $(ARGS)

faults: ## each link from finger to wheel broken while the robot drives: make faults ARGS="--only server-killed"
	@sh .make/install.sh test
	@sh .make/faults.sh $(ARGS)

figures: ## the tables of README.md, from e2e/published
	@sh .make/install.sh test
	@.venv/bin/python -m e2e.measure

mutants: ## small faults in what keeps the robot standing, which the tests must notice
	@sh .make/install.sh test
	@sh .make/mutants.sh $(ARGS)

coverage: ## the branches of the same, which the tests must all take
	@sh .make/install.sh test
	@sh .make/coverage.sh

lock: ## renew the locked versions of the Python packages
	@sh .make/lock.sh

clean: ## remove all that was installed or built here
	rm -rf .venv .cache .mypy_cache .ruff_cache .pytest_cache .hypothesis dist e2e/out \
		web/node_modules web/src/generated server/wax/web/dist

.PHONY: help run test check bench lab goals faults figures mutants coverage lock clean
