# The predictor with every float a double, its other names hidden: both kinds go into one program.
double_objects := $(patsubst %,$(B)/tests/double/%.o,$(predictor_parts) tests/double/double)
$(double_objects): $(B)/tests/double/%.o: %.c | $(B)/.test-packages
	@mkdir -p $(@D)
	$(call say,CC,$<)$(CC) $(HOST_FLAGS) -Wno-double-promotion -Dfloat=double $(foreach name,sqrt fabs copysign,-D__builtin_$(name)f=__builtin_$(name)) -c $< -o $@
$(B)/tests/double/double.o: $(double_objects)
	$(call say,LD,$@)$(LD) -r $^ -o $@
	$(Q)objcopy $(foreach name,start block displacement_ft size,--keep-global-symbol=double_$(name)) $@
$(B)/tests/host/test_predictor_double: $(B)/tests/double/double.o
