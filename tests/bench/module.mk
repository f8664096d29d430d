# Timings of the solvers.
$(B)/tests/bench/sim_bench: $(patsubst %.c,$(B)/%.o,$(wildcard tests/bench/*.c)) $(study_parts) $(host_lib) $(common_lib)
	$(call link,$(STUDY_LIBS))
