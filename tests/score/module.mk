# The predictor on landings that are not its model.
$(B)/tests/score/score: $(patsubst %.c,$(B)/%.o,$(wildcard tests/score/*.c)) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
test-programs: $(B)/tests/score/score

.PHONY: score
score: $(B)/tests/score/score ## longer | the predictor on seeded landings that are not its model, 1,500 in all: build/score/table.txt
	@mkdir -p $(B)/score
	$(B)/tests/score/score $(B)/score $(or $(FROM),0) $(or $(SERIES),500) $(if $(KIND),0 $(KIND)) | tee $(B)/score/table.txt
