# Hours of virtual time. The host's accounting alone: matrig's libraries and Unicorn do not go into one program.
$(B)/tests/soak/soak: $(B)/tests/soak/soak.o $(B)/host/host/collect/loss_tracker.o $(B)/host/host/collect/timebase.o $(hil_lib) $(common_lib)
	$(call link,$(HIL_LIBS))
test-programs: $(B)/tests/soak/soak

.PHONY: soak
soak: $(B)/tests/soak/soak $(firmware) ## longer | HOURS=1 SEED=1: virtual time with random faults; sent = received + declared lost, per message
	@mkdir -p $(B)/soak
	$(B)/tests/soak/soak $(or $(HOURS),1) $(or $(SEED),1) $(B)/soak | tee $(B)/soak/summary.txt
