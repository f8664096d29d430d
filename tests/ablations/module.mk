# What each part of elastic ground does: the standard and the friction series with one change at a time.
$(B)/tests/ablations/ablations: $(patsubst %.c,$(B)/%.o,$(wildcard tests/ablations/*.c)) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
test-programs: $(B)/tests/ablations/ablations

.PHONY: ablations
ablations: $(B)/tests/ablations/ablations ## longer | SEEDS=16 FIRST=10001: elastic ground with one part changed at a time: build/ablations/table.md
	@mkdir -p $(B)/ablations
	SEEDS=$(SEEDS) FIRST=$(FIRST) $(B)/tests/ablations/ablations host/campaign/ablations/parts.json host/campaign/series/standard.json:5 \
		host/campaign/series/friction.json:4 | tee $(B)/ablations/table.md
