.PHONY: test-circuits
test-circuits: in-build circuits ## tests | faults in copies of the schematics are found: wires cut, values and nets changed, rules broken (3 min)
	@tests/run-all.sh tests/circuits/circuits.sh
