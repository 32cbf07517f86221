# The scripts are in .make/; every target first installs what it needs.

help: ## this list
	@sed -n 's/^\([a-z-]*\):.*## /make \1	/p' Makefile | expand -t 18

run: ## install what is missing, build the page, serve it: make run ARGS="--config config/wax.toml"
	@sh .make/install.sh run
	@exec .venv/bin/wax $(ARGS)

unit: ## the inner loop: unit tests of both languages, in less than two minutes
	@sh .make/test.sh unit

test: ## all checks and tests, browsers included, in less than twenty minutes
	@sh .make/test.sh test

test-all: ## the same at full length, and the tests of the measuring suites
	@sh .make/test.sh all

check: ## lint, format, strict types and import rules, for both languages
	@sh .make/install.sh check
	@sh .make/check.sh

bench: ## the benchmarks, as JSON
	@sh .make/install.sh test
	@sh .make/suite.sh bench $(ARGS)

lab: ## the thesis's chapter 5 over emulated networks, with a report: make lab ARGS="--only E3"
	@sh .make/install.sh test
	@sh .make/suite.sh lab $(ARGS)

goals: ## the goals, compared with stock aiortc and LiveKit: make goals ARGS="--only modem"
	@sh .make/install.sh test
	@sh .make/suite.sh lab --goals $(ARGS)

sound: ## the sound at the ear, by both players and the peers: make sound ARGS="--resume"
	@sh .make/install.sh test
	@sh .make/suite.sh lab --sound $(ARGS)

faults: ## break each link from finger to wheel while the robot drives: make faults ARGS="--only server-killed"
	@sh .make/install.sh test
	@sh .make/suite.sh faults $(ARGS)

public: ## hostile strangers while somebody drives, and bad days: make public ARGS="--only hostile-mix"
	@sh .make/install.sh test
	@sh .make/suite.sh public $(ARGS)

cluster: ## rooms of LiveKit beside the robot's own server, and what breaks: make cluster ARGS="--only watch"
	@sh .make/install.sh test
	@sh .make/suite.sh cluster $(ARGS)

voice: ## a voice to the robot: its delay, and what it adds to the commands': make voice ARGS="--only mouth*"
	@sh .make/install.sh test
	@sh .make/suite.sh voice $(ARGS)

page: ## what the page takes: first picture, main thread, input to the gate, memory: make page ARGS="--only input*"
	@sh .make/install.sh test
	@sh .make/suite.sh page $(ARGS)

drivers: ## each driver, from the key to its wire, and how its robot stops: make drivers ARGS="--only ros2/*"
	@sh .make/install.sh test
	@sh .make/suite.sh drivers $(ARGS)

gallery: ## photograph the page in every state, window and theme: make gallery ARGS="--only driving"
	@sh .make/install.sh test
	@sh .make/suite.sh gallery $(ARGS)

figures: ## render the tables of README.md and e2e/published/README.md
	@sh .make/install.sh test
	@.venv/bin/python -m e2e.measure

mutants: ## mutation testing of the safety code
	@sh .make/install.sh test
	@sh .make/suite.sh mutants $(ARGS)

soak: ## half an hour of an operator and observers who come and go: what grows; an hour of tape: its step
	@sh .make/install.sh test
	@sh .make/suite.sh soak $(ARGS)

fuzz: ## a million inputs for each parser, or 20 minutes, led by coverage: make fuzz ARGS="--only rtcp"
	@sh .make/install.sh test
	@sh .make/suite.sh fuzz $(ARGS)

ablation: ## half and double of each constant of congestion control, in simulation
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

.PHONY: help run unit test test-all check bench lab goals sound faults public cluster voice page drivers gallery figures mutants soak fuzz ablation coverage lock clean
