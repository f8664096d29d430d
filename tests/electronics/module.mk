# Drawn boards on the emulated rig. Of the host only the straight line of matrig calibrate: what links Unicorn links nothing of libserialport.
electronics_parts := $(B)/tests/electronics/boards.o $(patsubst %,$(B)/host/%.o,firmware/config host/calibrate/fit host/base/statistics host/base/error)
$(B)/tests/electronics/electronics: $(B)/tests/electronics/main.o $(electronics_parts) $(hil_lib) $(common_lib) | $(firmware)
	$(call link,$(HIL_LIBS))
test-programs: $(B)/tests/electronics/electronics
$(B)/tests/hil/test_electronics: $(electronics_parts)

.PHONY: electronics
electronics: in-build all $(B)/tests/electronics/electronics ## studies | BOARDS=1000 LANDINGS=100: drawn boards and what they measure: docs/measured/electronics.md
	@tests/electronics/page.sh $(B)/electronics $(or $(BOARDS),1000) $(or $(LANDINGS),100)
