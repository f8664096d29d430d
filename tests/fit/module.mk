# The fit against cases whose truth is known.
$(B)/tests/host/test_fit: $(B)/tests/fit/cheap.o
$(B)/tests/fit/coverage: $(B)/tests/fit/coverage.o $(B)/tests/fit/cheap.o $(study_parts) $(host_lib) $(common_lib)
	$(call link,$(STUDY_LIBS))
