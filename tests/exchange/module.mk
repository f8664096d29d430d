# A reader of another hand, as a benchmark.
$(B)/tests/exchange/decode: $(B)/tests/exchange/decode.o $(host_lib) $(common_lib)
	$(call link,$(HOST_LIBS))
