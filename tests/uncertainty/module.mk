# Drawn calibrations against the uncertainty budget. Of the host only the fit and the budget: what links Unicorn links nothing of libserialport.
uncertainty_parts := $(patsubst %,$(B)/host/%.o,firmware/config host/calibrate/fit host/calibrate/budget host/base/statistics host/base/error)
$(B)/tests/uncertainty/study: $(B)/tests/uncertainty/study.o $(uncertainty_parts) $(hil_lib) $(common_lib)
	$(call link,$(HIL_LIBS))
test-programs: $(B)/tests/uncertainty/study

.PHONY: uncertainty
uncertainty: in-build $(B)/tests/uncertainty/study ## studies | DRAWS=500: drawn calibrations and landings against the uncertainty budget: docs/measured/uncertainty.md
	@tests/uncertainty/page.sh $(or $(DRAWS),500)
