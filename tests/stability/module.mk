# Every answer checked by a second method.
$(B)/tests/stability/stability: $(patsubst %.c,$(B)/%.o,$(wildcard tests/stability/*.c)) $(patsubst %,$(B)/tests/sim_reference/%.o,scene model march) \
		$(study_parts) $(host_lib) $(common_lib)
	$(call link,$(STUDY_LIBS))
test-programs: $(B)/tests/stability/stability

.PHONY: stability
stability: $(B)/tests/stability/stability ## longer | 2,000 scenes, 5,000 landings and 5,000 chains, every answer checked by a second method: build/stability/table.csv, landings.csv, chain.csv
	@mkdir -p $(B)/stability
	$(B)/tests/stability/stability $(B)/stability | tee $(B)/stability/summary.txt
	$(B)/tests/stability/stability --fixed $(B)/stability | tee $(B)/stability/landings.txt
	$(B)/tests/stability/stability --chain $(B)/stability | tee $(B)/stability/chain.txt

.PHONY: error-bars
error-bars: $(B)/tests/stability/stability ## longer | 5,000 scenes, true errors of every solver over those that it states: build/stability/bars.csv (20 min)
	@mkdir -p $(B)/stability
	$(B)/tests/stability/stability --bars --minutes 60 $(B)/stability | tee $(B)/stability/bars.txt
