# Every solver's error against its run time: matrig error on six scenes, then the onboard predictor.
$(B)/tests/error_report/error-report: $(patsubst %.c,$(B)/%.o,$(wildcard tests/error_report/*.c)) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
test-programs: $(B)/tests/error_report/error-report

error_scenes := rstar_fig3_7_n30 rstar_fig3_7_n30_tanh rstar_fig3_6 full_width_144000 rstar_fig3_12_tad1 consistent_fig3_7
.PHONY: error-report
error-report: $(B)/tests/error_report/error-report $(B)/matrig $(studies) ## studies | every solver's error against its run time, six scenes and predictor: build/error-report/*.txt, *.md, *.svg
	@mkdir -p $(B)/error-report
	for s in $(error_scenes); do $(B)/matrig error host/scenes/$$s.json --plot $(B)/error-report/$$s.svg >$(B)/error-report/$$s.txt || exit 1; done
	$(B)/tests/error_report/error-report $(B)/error-report | tee $(B)/error-report/report.md
