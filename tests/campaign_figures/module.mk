# Figures 4.1 to 5.12 of the 1973 report.
$(B)/tests/campaign_figures/campaign-figures: $(patsubst %.c,$(B)/%.o,$(wildcard tests/campaign_figures/*.c)) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
test-programs: $(B)/tests/campaign_figures/campaign-figures

.PHONY: campaign-figures
campaign-figures: $(B)/tests/campaign_figures/campaign-figures $(B)/matrig ## studies | SEEDS=4: figures 4.1 to 5.12 from the series: build/campaign-figures/*.svg, figures.md
	@mkdir -p $(B)/campaign-figures
	$(B)/matrig scale host/campaign/series/standard.json -o $(B)/campaign-figures/standard_prototype.json >$(B)/campaign-figures/scale.txt
	$(B)/tests/campaign_figures/campaign-figures $(B)/campaign-figures $(or $(SEEDS),4) | tee $(B)/campaign-figures/figures.md
