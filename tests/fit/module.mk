# The fit against cases whose truth is known.
fit_truths := $(B)/tests/fit/cheap.o $(B)/tests/fit/runway.o
$(B)/tests/host/test_fit: $(fit_truths)
$(B)/tests/fit/coverage: $(B)/tests/fit/coverage.o $(B)/tests/fit/cheap.o $(study_parts) $(host_lib) $(common_lib)
	$(call link,$(STUDY_LIBS))
$(B)/tests/fit/misfits: $(B)/tests/fit/misfits.o $(fit_truths) $(study_parts) $(host_lib) $(common_lib)
	$(call link,$(STUDY_LIBS))
test-programs: $(B)/tests/fit/misfits

.PHONY: fit-misfits
fit-misfits: $(B)/tests/fit/misfits ## longer | how often matrig fit notices that its model cannot be the data's: build/fit-misfits/table.txt
	@mkdir -p $(B)/fit-misfits
	nice $(B)/tests/fit/misfits $(B)/fit-misfits $(or $(FROM),1001) $(or $(RIGHT),60) $(or $(WRONG),20) $(or $(MATS),210) | tee $(B)/fit-misfits/table.txt
