# A second method, which shares nothing with the solvers.
reference_objects := $(patsubst %,$(B)/tests/sim_reference/%.o,scene model march)
$(call tests_of,sim_reference): $(B)/tests/sim_reference/test_%: $(B)/tests/sim_reference/test_%.o $(reference_objects) $(host_lib) $(common_lib)
	$(call link,-lcmocka $(HOST_LIBS))
$(B)/tests/sim_reference/reference: $(B)/tests/sim_reference/reference.o $(reference_objects)
	$(call link,-ljansson -lm)
