# A recorded landing's predictor computed again on this computer: what the board sent must follow from its record.
again := $(B)/tests/again/again
$(again): $(again).o $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
test-programs: $(again)
