# Pages that programs make.
$(B)/docs/reference/reference: $(call objects,host,$(wildcard docs/reference/*.c)) $(board_tables) $(host_lib) $(common_lib)
	@mkdir -p $(@D)
	$(call link,$(HOST_LIBS))
test-programs: $(B)/docs/reference/reference

.PHONY: reference
reference: $(B)/docs/reference/reference ## every day | the pages of docs/reference, from the tables that the programs are made from
	$< docs/reference

.PHONY: pictures
pictures: in-build $(B)/.browser-packages all demo ## longer | the live page and the report as PNG, docs/pictures, and the demo's figures, docs/measured/demo.md
	@python3 tests/browser/pictures.py
