# A changed predictor passes this before its image is released (README.md here).
certify_parts := tests/certify/land.c tests/board/truth_run.c tests/score/truth.c tests/score/play.c tests/runs/runfile.c
$(B)/tests/certify/land: $(patsubst %.c,$(B)/%.o,$(certify_parts)) $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
test-programs: $(B)/tests/certify/land

.PHONY: certify
certify: in-build $(B)/.test-packages all $(variants) $(B)/tests/certify/land $(B)/tests/again/again $(B)/tests/runs/synthesise ## longer | PAGE=yes: a predictor before its image is released: every case of tests/certify against its bounds: build/certify/table.md
	@python3 tests/certify/certify.py $(if $(PAGE),--page)

.PHONY: advised
advised: in-build all ## longer | PAGE=yes: after make certify: what advise would have said before each of its landings, series by series: build/certify/advised.md
	@python3 tests/certify/advised.py $(if $(PAGE),--page)
