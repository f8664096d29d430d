# Every solver's error against its run time.
$(B)/tests/error_report/error-report: $(patsubst %.c,$(B)/%.o,$(wildcard tests/error_report/*.c)) $(study_parts) $(host_lib) $(common_lib)
	$(call link,$(STUDY_LIBS))
test-programs: $(B)/tests/error_report/error-report

.PHONY: error-report
error-report: $(B)/tests/error_report/error-report ## studies | every solver's error against its run time, seven scenes, engines and predictor: build/error-report/index.html
	@mkdir -p $(B)/error-report
	$(B)/tests/error_report/error-report $(B)/error-report
