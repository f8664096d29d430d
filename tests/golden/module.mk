# Golden landings, with the configuration that is built into the firmware: a recording says what of it was given.
$(B)/tests/golden/golden: $(patsubst %.c,$(B)/%.o,$(wildcard tests/golden/*.c)) $(B)/host/firmware/config.o $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS) -lz)
test-programs: $(B)/tests/golden/golden

.PHONY: golden
golden: all $(B)/tests/golden/golden ## tests | keep what today's image says to the golden landings as a new version (FIRST=1: all anew): tests/golden
	@FIRST=$(FIRST) tests/golden/record.sh
