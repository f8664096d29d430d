# The report's series of landings.
series := $(addprefix host/landing_series/series/,$(addsuffix .json,standard standard_stop friction control_mild control_fresh bands_preliminary \
	bands_detailed diagonal cleats cleats_bent cleats_rising stiffeners dyess dyess_clay))
$(B)/tests/scoreboard/scoreboard: $(patsubst %.c,$(B)/%.o,$(wildcard tests/scoreboard/*.c)) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
test-programs: $(B)/tests/scoreboard/scoreboard

.PHONY: scoreboard
scoreboard: $(B)/tests/scoreboard/scoreboard ## longer | SEEDS=16 FIRST=1: the report's series of landings, observed | weightless | elastic ground: build/scoreboard/table.md
	@mkdir -p $(B)/scoreboard
	SEEDS=$(SEEDS) FIRST=$(FIRST) $(B)/tests/scoreboard/scoreboard $(series) | tee $(B)/scoreboard/table.md
