# What tests of links run.
$(B)/tests/link/longlanding: $(B)/tests/link/longlanding.o $(B)/host/host/link/candump.o $(common_lib)
	$(call link,-lm)
# For LD_PRELOAD: clocks that jump or run fast, a full disk; one call that fails; serial ports.
$(B)/tests/link/%.so: tests/link/%.c | $(B)/.test-packages
	@mkdir -p $(@D)
	$(call say,CC,$<)$(CC) $(HOST_FLAGS) -shared -fPIC $< -ldl -o $@
test-programs: $(B)/tests/link/longlanding $(B)/tests/link/faults.so $(B)/tests/link/kth.so $(B)/tests/link/ports.so
