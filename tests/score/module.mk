# The predictor on landings that are not its model.
score_parts := $(patsubst %.c,$(B)/%.o,$(filter-out tests/score/main.c tests/score/before.c tests/score/risk.c tests/score/closed.c tests/score/waves.c,$(wildcard tests/score/*.c)))
$(B)/tests/score/score: $(B)/tests/score/main.o $(score_parts) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
$(B)/tests/score/before: $(B)/tests/score/before.o $(score_parts) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
$(B)/tests/score/risk: $(B)/tests/score/risk.o $(score_parts) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
$(B)/tests/score/closed: $(B)/tests/score/closed.o $(score_parts) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
$(B)/tests/score/waves: $(B)/tests/score/waves.o $(score_parts) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
test-programs: $(patsubst %,$(B)/tests/score/%,score before risk closed waves)

.PHONY: score
score: $(B)/tests/score/score ## longer | the predictor on seeded landings that are not its model, 1,500 in all: build/score/table.txt
	@mkdir -p $(B)/score
	$(B)/tests/score/score $(B)/score $(or $(FROM),0) $(or $(SERIES),500) $(if $(KIND),0 $(KIND)) | tee $(B)/score/table.txt
