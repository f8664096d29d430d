# The report's series of landings.
series := $(addprefix host/landing_series/series/,$(addsuffix .json,standard standard_stop friction control_mild control_fresh bands_preliminary \
	bands_detailed diagonal cleats cleats_bent cleats_rising stiffeners dyess dyess_clay))
$(B)/tests/campaigns/campaigns: $(patsubst %.c,$(B)/%.o,$(wildcard tests/campaigns/*.c)) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
test-programs: $(B)/tests/campaigns/campaigns

.PHONY: campaigns
campaigns: $(B)/tests/campaigns/campaigns ## longer | SEEDS=16 FIRST=1: the report's series of landings, observed | weightless | elastic ground: build/campaigns/table.md
	@mkdir -p $(B)/campaigns
	SEEDS=$(SEEDS) FIRST=$(FIRST) $(B)/tests/campaigns/campaigns $(series) | tee $(B)/campaigns/table.md
