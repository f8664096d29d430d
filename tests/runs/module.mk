# The recorded landings, synthesised.
$(B)/tests/runs/synthesise: $(patsubst %.c,$(B)/%.o,$(wildcard tests/runs/*.c))
	$(call link,-lm)
test-programs: $(B)/tests/runs/synthesise

.PHONY: runs
runs: $(B)/tests/runs/synthesise ## studies | synthesise the recorded landings again and compare them with those in tests/runs
	@mkdir -p $(B)/runs
	$(B)/tests/runs/synthesise $(B)/runs
	@for run in tests/runs/*.run; do cmp $$run $(B)/runs/$$(basename $$run) && echo "$$run: the same" || exit 1; done
