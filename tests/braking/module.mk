# Landings with the edge of a brake and the pulses of a wheel, drawn.
$(B)/tests/braking/braked: $(B)/tests/braking/braked.o $(B)/tests/runs/runfile.o
	$(call link,-lm)
test-programs: $(B)/tests/braking/braked
