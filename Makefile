# The scripts are in .make/; every target first installs what it needs.

help: ## this list
	@sed -n 's/^\([a-z-]*\):.*## /make \1	/p' Makefile | expand -t 18

run: ## install what is missing, build the page, serve it: make run ARGS="--config config/wax.toml"
	@sh .make/install.sh run
	@exec .venv/bin/wax $(ARGS)

unit: ## the inner loop: unit tests of both languages, in less than a minute
	@sh .make/test.sh unit

test: ## all checks and tests, browsers included, in about ten minutes
	@sh .make/test.sh test

test-all: ## the same at full length, and the tests of the measuring suites
	@sh .make/test.sh all

check: ## lint, format, strict types and import rules, for both languages
	@sh .make/install.sh check
	@sh .make/check.sh

manual: ## rewrite config/wax.toml from the settings in server/wax/config
	@sh .make/install.sh check
	@mkdir -p .cache && .venv/bin/python -m wax.config >.cache/wax.toml && mv .cache/wax.toml config/wax.toml

measure: ## measure all that is published, three hours, resumable: make measure ARGS="stop --quick"
	@sh .make/install.sh test
	@sh .make/suite.sh measure $(ARGS)

gallery: ## photograph the page in every state, window and theme: make gallery ARGS="-k driving"
	@sh .make/install.sh test
	@sh .make/suite.sh gallery $(ARGS)

mutants: ## mutation testing of the safety code
	@sh .make/install.sh test
	@sh .make/suite.sh mutants $(ARGS)

fuzz: ## up to a million inputs or 20 minutes for each parser, guided by coverage: make fuzz ARGS="fuzz-rtcp"
	@sh .make/install.sh test
	@sh .make/suite.sh fuzz $(ARGS)

ablation: ## halve and double each constant of congestion control, in simulation
	@sh .make/install.sh test
	@.venv/bin/python -m tests.ablation $(ARGS)

coverage: ## branch coverage of the safety code, which must be complete
	@sh .make/install.sh test
	@sh .make/suite.sh coverage

lock: ## renew the locked versions of the Python packages
	@sh .make/install.sh run
	@sh .make/lock.sh

clean: ## remove everything installed or built here
	rm -rf .venv .cache .mypy_cache .ruff_cache .pytest_cache .hypothesis dist e2e/out \
		web/node_modules web/src/generated server/wax/web/dist

.PHONY: help run unit test test-all check manual measure gallery mutants fuzz ablation coverage lock clean
