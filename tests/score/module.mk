# The predictor on landings that are not its model.
score_programs := risk foresight outcome
score_mains := $(patsubst %,tests/score/%.c,main $(score_programs))
score_parts := $(patsubst %.c,$(B)/%.o,$(filter-out $(score_mains),$(wildcard tests/score/*.c)))
$(patsubst %,$(B)/tests/score/%,$(score_programs)): %: %.o $(score_parts) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
$(B)/tests/score/score: $(B)/tests/score/main.o $(score_parts) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
test-programs: $(patsubst %,$(B)/tests/score/%,score $(score_programs))

.PHONY: score
score: $(B)/tests/score/score ## longer | the predictor on seeded landings that are not its model, 1,500 in all: build/score/table.txt
	@mkdir -p $(B)/score
	$(B)/tests/score/score $(B)/score $(or $(FROM),0) $(or $(SERIES),500) $(if $(KIND),0 $(KIND)) | tee $(B)/score/table.txt

.PHONY: score-foresight
score-foresight: $(B)/tests/score/foresight ## longer | FROM=700 SERIES=60: what is said before touchdown and during a landing, on perturbed truths, against simple rules: build/score/foresight.txt (an hour)
	@mkdir -p $(B)/score
	$(B)/tests/score/foresight $(B)/score learn
	$(B)/tests/score/foresight $(B)/score play $(or $(FROM),700) $(or $(SERIES),60)
	$(B)/tests/score/foresight $(B)/score table $(or $(FROM),700) $(or $(SERIES),60) | tee $(B)/score/foresight.txt

.PHONY: score-outcome
score-outcome: $(B)/tests/score/outcome ## longer | FROM=6000 SERIES=100: how well transducers and survey tell which zone the wheel reached: build/score/outcome.txt (2 min)
	@mkdir -p $(B)/score
	$(B)/tests/score/outcome $(B)/score $(or $(FROM),6000) $(or $(SERIES),100) chain elastic late shut patchy heavy pulsed | tee $(B)/score/outcome.txt
