# Figures 4.1 to 5.12 of the 1973 report.
$(B)/tests/series_figures/series-figures: $(patsubst %.c,$(B)/%.o,$(wildcard tests/series_figures/*.c)) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
test-programs: $(B)/tests/series_figures/series-figures

.PHONY: series-figures
series-figures: $(B)/tests/series_figures/series-figures $(B)/matrig ## studies | SEEDS=4: figures 4.1 to 5.12 from the series: build/series-figures/*.svg, figures.md
	@mkdir -p $(B)/series-figures
	$(B)/matrig scale host/landing_series/series/standard.json -o $(B)/series-figures/standard_prototype.json >$(B)/series-figures/scale.txt
	$(B)/tests/series_figures/series-figures $(B)/series-figures $(or $(SEEDS),4) | tee $(B)/series-figures/figures.md
