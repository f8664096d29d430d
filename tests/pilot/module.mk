# The pilot study of the report.
$(B)/tests/pilot/pilot: $(B)/tests/pilot/pilot.o $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
test-programs: $(B)/tests/pilot/pilot

.PHONY: pilot
pilot: $(B)/tests/pilot/pilot ## studies | SEEDS=8: the pilot study's six results (report B.3), observed | computed | verdict: build/pilot.md
	$(B)/tests/pilot/pilot $(or $(SEEDS),8) | tee $(B)/pilot.md
