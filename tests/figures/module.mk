# Figures of the 1973 report.
$(B)/tests/figures/figures: $(patsubst %.c,$(B)/%.o,$(wildcard tests/figures/*.c)) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
test-programs: $(B)/tests/figures/figures

.PHONY: figures
figures: $(B)/tests/figures/figures ## studies | figures 3.6 to 3.12 of the 1973 report, redrawn: build/figures/*.svg; the table on stdout
	@mkdir -p $(B)/figures
	$(B)/tests/figures/figures $(B)/figures
