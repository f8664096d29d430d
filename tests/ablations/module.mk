# What each part of elastic ground does: the standard and the friction series with one change at a time.
$(B)/tests/ablations/ablations: $(patsubst %.c,$(B)/%.o,$(wildcard tests/ablations/*.c)) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
test-programs: $(B)/tests/ablations/ablations

.PHONY: ablations
ablations: $(B)/tests/ablations/ablations ## longer | SEEDS=16 FIRST=10001: elastic ground with one part changed at a time: build/ablations/table.md
	@mkdir -p $(B)/ablations
	SEEDS=$(SEEDS) FIRST=$(FIRST) $(B)/tests/ablations/ablations host/landing_series/ablations/parts.json host/landing_series/series/standard.json:5 \
		host/landing_series/series/friction.json:4 | tee $(B)/ablations/table.md
